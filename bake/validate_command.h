// overcast-bake validate PATH
#pragma once

#include <string>
#include <vector>

namespace overcast {

int validateCommand(const std::vector<std::string>& arguments);

}  // namespace overcast
