#include "tests/golden/golden.h"

#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "formats/files.h"
#include "tests/commands/shell.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

// Runs a program with its output in a log file.
Result<Done> runProgram(const fs::path& program, const std::vector<std::string>& arguments, const fs::path& log) {
  std::string command = test::quoted(program.string());
  for (const std::string& argument : arguments) command += fmt::format(" {}", test::quoted(argument));
  const test::ShellResult result = test::shell(fmt::format("{} > {} 2>&1", command, test::quoted(log.string())));
  if (result.exitCode == 0) return Done{};
  return Error{program.filename().string(), "", fmt::format("exit code {}, see {} (command: {})", result.exitCode, log.string(), command)};
}

Golden goldenFromJson(const nlohmann::json& json) {
  Golden golden;
  golden.name = json.at("name");
  golden.scene = json.at("scene");
  golden.frame = json.at("frame");
  golden.bake = json.at("bake").get<std::vector<std::string>>();
  golden.play = json.at("play").get<std::vector<std::string>>();
  const auto& tolerance = json.at("tolerance");
  golden.tolerance = {tolerance.at("rmse"), tolerance.at("off"), tolerance.at("share")};
  golden.reason = json.at("reason");
  return golden;
}

fs::path goldenPicture(const Golden& golden, const GoldenFolders& folders) {
  return folders.source / "data/golden" / (golden.name + ".png");
}

}  // namespace

Result<std::vector<Golden>> readGoldens(const fs::path& file) {
  const auto bytes = readFile(file);
  if (!bytes.ok()) return bytes.error();
  const auto* text = reinterpret_cast<const char*>(bytes.value().data());
  const auto json = nlohmann::json::parse(text, text + bytes.value().size(), nullptr, false);
  if (!json.is_object() || !json.contains("goldens")) return Error{file.string(), "", "not a list of golden pictures"};
  std::vector<Golden> goldens;
  for (const auto& entry : json["goldens"]) {
    try {
      goldens.push_back(goldenFromJson(entry));
    } catch (const nlohmann::json::exception& problem) {
      return Error{file.string(), fmt::format("goldens/{}", goldens.size()), problem.what()};
    }
  }
  return goldens;
}

Result<fs::path> renderGolden(const Golden& golden, const GoldenFolders& folders) {
  const fs::path work = folders.output / golden.name;
  std::error_code ignored;
  fs::remove_all(work, ignored);
  fs::create_directories(work, ignored);
  const fs::path file = fs::path(golden.scene).has_extension() ? golden.scene : golden.scene + ".gltf";
  const std::string name = file.stem().string();
  std::vector<std::string> bake = {(folders.source / "data/scenes" / file).string(), "-o", (work / "baked").string(), "--name", name};
  bake.insert(bake.end(), golden.bake.begin(), golden.bake.end());
  if (auto done = runProgram(folders.programs / "overcast-bake", bake, work / "bake.log"); !done.ok()) return done.error();
  const std::string frames = fmt::format("{0}:{0}", golden.frame);
  fs::path picture = work / "picture.png";
  std::vector<std::string> play = {(work / "baked" / (name + ".gltf")).string(), "--headless", "--frames", frames, "-o", picture.string()};
  play.insert(play.end(), golden.play.begin(), golden.play.end());
  if (auto done = runProgram(folders.programs / "overcast-player", play, work / "play.log"); !done.ok()) return done.error();
  return picture;
}

Result<Difference> checkGolden(const Golden& golden, const fs::path& picture, const GoldenFolders& folders) {
  const auto rendered = readPng(picture);
  if (!rendered.ok()) return rendered.error();
  const auto expected = readPng(goldenPicture(golden, folders));
  if (!expected.ok()) return expected.error();
  auto difference = compare(rendered.value(), expected.value(), golden.tolerance.off);
  if (!difference.ok()) return Error{picture.string(), "", difference.error().reason};
  if (within(difference.value(), golden.tolerance)) return difference;
  const fs::path where = folders.output / golden.name / "difference.png";
  if (auto written = writePng(where, differenceImage(rendered.value(), expected.value())); !written.ok()) return written.error();
  return Error{picture.string(), "",
               fmt::format("{} (allowed: rmse {}, {} % off); golden {}, difference {}", describe(difference.value(), golden.tolerance.off),
                           golden.tolerance.rmse, 100.0 * golden.tolerance.share, goldenPicture(golden, folders).string(), where.string())};
}

Result<Done> renewGolden(const Golden& golden, const fs::path& picture, const GoldenFolders& folders) {
  const auto bytes = readFile(picture);
  if (!bytes.ok()) return bytes.error();
  return writeFileAtomically(goldenPicture(golden, folders), bytes.value());
}

}  // namespace overcast
