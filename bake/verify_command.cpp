#include "bake/verify_command.h"

#include <filesystem>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bake/command.h"
#include "bake/terrain_options.h"
#include "bake/verify.h"
#include "formats/console.h"

namespace overcast {

int verifyCommand(const std::vector<std::string>& arguments) {
  CLI::App app("Measures the occluders and apertures of a baked scene again from their source meshes; prints one line for every lie.",
               "overcast-bake verify");
  std::filesystem::path scene;
  std::vector<std::filesystem::path> sources;
  app.add_option("SCENE", scene, "a baked .gltf")->required();
  app.add_option("--source", sources, "the meshes and scenes it was baked from")->required();
  TerrainOptions terrain;
  addTerrainOptions(app, terrain);
  bool json = false;
  app.add_flag("--json", json, "print one JSON document instead of lines");
  if (const int code = parseArguments(app, arguments); code >= 0) return code;
  const auto findings = verify(scene, sources, terrain);
  if (!findings) {
    complain(findings.error());
    return kBadInput;
  }
  if (json) {
    const nlohmann::ordered_json document = {
        {"format", "overcast-verify"}, {"version", 1}, {"file", scene.string()}, {"findings", findings.value()}};
    printResult(document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
    return findings.value().empty() ? kOk : kNotValid;
  }
  for (const std::string& finding : findings.value()) printResult(oneLine(finding) + "\n");
  if (findings.value().empty()) printMessage(oneLine(scene.string() + ": verified") + "\n");
  return findings.value().empty() ? kOk : kNotValid;
}

}  // namespace overcast
