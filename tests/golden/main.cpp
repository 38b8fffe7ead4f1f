// overcast-golden: renders the golden pictures and compares them, or makes them anew. Exit codes: 0 all as they should be, 1 not.
#include <glob.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "tests/golden/golden.h"

namespace {

using namespace overcast;

// Goldens come from Mesa's lavapipe: another device may round otherwise.
void chooseLavapipe() {
  glob_t found{};
  if (glob("/usr/share/vulkan/icd.d/lvp_icd*.json", 0, nullptr, &found) == 0) setenv("VK_DRIVER_FILES", found.gl_pathv[0], 1);
  globfree(&found);
}

bool checkOrRenew(const Golden& golden, const GoldenFolders& folders, bool renew) {
  const auto complain = [&](const Error& error) {
    std::fprintf(stderr, "%s: %s\n", golden.name.c_str(), message(error).c_str());
    return false;
  };
  const auto picture = renderGolden(golden, folders);
  if (!picture.ok()) return complain(picture.error());
  if (renew) {
    const auto renewed = renewGolden(golden, picture.value(), folders);
    if (!renewed.ok()) return complain(renewed.error());
    std::printf("%s: renewed; look at it before committing\n", golden.name.c_str());
    return true;
  }
  const auto difference = checkGolden(golden, picture.value(), folders);
  if (!difference.ok()) return complain(difference.error());
  std::printf("%s: %s\n", golden.name.c_str(), describe(difference.value(), golden.tolerance.off).c_str());
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Renders the golden pictures of data/golden and compares them. Exit codes: 0 all as they should be, 1 not.");
  std::vector<std::string> names;
  bool renew = false;
  app.add_option("NAME", names, "pictures to look at; all when none is named");
  app.add_flag("--renew", renew, "make the pictures the new goldens");
  CLI11_PARSE(app, argc, argv);

  const GoldenFolders folders{OVERCAST_SOURCE_FOLDER, OVERCAST_BINARY_FOLDER, OVERCAST_GOLDEN_OUTPUT};
  const auto goldens = readGoldens(folders.source / "data/golden/goldens.json");
  if (!goldens.ok()) {
    std::fprintf(stderr, "overcast-golden: %s\n", message(goldens.error()).c_str());
    return 1;
  }
  chooseLavapipe();
  bool allGood = true;
  for (const Golden& golden : goldens.value()) {
    if (!names.empty() && std::find(names.begin(), names.end(), golden.name) == names.end()) continue;
    allGood = checkOrRenew(golden, folders, renew) && allGood;
  }
  return allGood ? 0 : 1;
}
