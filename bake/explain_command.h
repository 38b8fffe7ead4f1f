// overcast-bake explain INPUT [--svg FILE]
#pragma once

#include <string>
#include <vector>

namespace overcast {

int explainCommand(const std::vector<std::string>& arguments);

}  // namespace overcast
