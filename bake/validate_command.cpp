#include "bake/validate_command.h"

#include <cstdio>

#include <CLI/CLI.hpp>

#include "bake/command.h"
#include "bake/validate.h"

namespace overcast {

int validateCommand(const std::vector<std::string>& arguments) {
  CLI::App app("Checks a baked scene or a volume; prints one line per finding.", "overcast-bake validate");
  std::filesystem::path path;
  app.add_option("PATH", path, "a baked .gltf or a .vdb file")->required();
  if (const int code = parseArguments(app, arguments); code >= 0) return code;
  const auto findings = validate(path);
  if (!findings) {
    complain(findings.error());
    return kBadInput;
  }
  for (const std::string& finding : findings.value()) fmt::print("{}\n", finding);
  if (findings.value().empty()) fmt::print(stderr, "{}: valid\n", path.string());
  return findings.value().empty() ? kOk : kNotValid;
}

}  // namespace overcast
