// overcast-bake [bake] INPUT... -o FOLDER
#pragma once

#include <string>
#include <vector>

namespace overcast {

int bakeCommand(const std::vector<std::string>& arguments);

}  // namespace overcast
