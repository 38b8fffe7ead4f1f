#include "bake/verify_command.h"

#include <filesystem>

#include <CLI/CLI.hpp>

#include "bake/command.h"
#include "bake/verify.h"
#include "formats/console.h"

namespace overcast {

int verifyCommand(const std::vector<std::string>& arguments) {
  CLI::App app("Measures the occluders of a baked scene again from their source meshes; prints one line for every lie.",
               "overcast-bake verify");
  std::filesystem::path scene;
  std::vector<std::filesystem::path> sources;
  app.add_option("SCENE", scene, "a baked .gltf")->required();
  app.add_option("--source", sources, "the meshes and scenes it was baked from")->required();
  if (const int code = parseArguments(app, arguments); code >= 0) return code;
  const auto findings = verify(scene, sources);
  if (!findings) {
    complain(findings.error());
    return kBadInput;
  }
  for (const std::string& finding : findings.value()) printResult(oneLine(finding) + "\n");
  if (findings.value().empty()) printMessage(oneLine(scene.string() + ": verified") + "\n");
  return findings.value().empty() ? kOk : kNotValid;
}

}  // namespace overcast
