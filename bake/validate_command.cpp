#include "bake/validate_command.h"

#include <CLI/CLI.hpp>

#include "bake/command.h"
#include "bake/validate.h"
#include "formats/console.h"

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
  for (const std::string& finding : findings.value()) printResult(oneLine(finding) + "\n");
  if (findings.value().empty()) printMessage(oneLine(path.string() + ": valid") + "\n");
  return findings.value().empty() ? kOk : kNotValid;
}

}  // namespace overcast
