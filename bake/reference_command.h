// `overcast-bake reference`.
#pragma once

#include <string>
#include <vector>

namespace overcast {

int referenceCommand(const std::vector<std::string>& arguments);

}  // namespace overcast
