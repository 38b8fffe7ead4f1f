// Depfile: which files an output was made from, in the syntax that make and ninja read (GNU make's, as compilers write it under -MMD -MP).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/result.h"

namespace overcast {

/// One output and what it was made from.
struct Dependencies {
  std::filesystem::path target;
  std::vector<std::filesystem::path> inputs;
};

/// One rule for each output, and an empty rule for each input so that deleting one does not stop make. Spaces, tabs, #, $, : and the
/// backslashes before them are escaped. An Error that names a path with a line break, which the syntax cannot express.
Result<std::string> depfileText(const std::vector<Dependencies>& rules);

}  // namespace overcast
