// overcast-bake verify SCENE --source MESH...
#pragma once

#include <string>
#include <vector>

namespace overcast {

int verifyCommand(const std::vector<std::string>& arguments);

}  // namespace overcast
