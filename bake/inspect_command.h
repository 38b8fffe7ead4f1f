// overcast-bake inspect PATH
#pragma once

#include <string>
#include <vector>

namespace overcast {

int inspectCommand(const std::vector<std::string>& arguments);

}  // namespace overcast
