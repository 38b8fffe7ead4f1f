// overcast-make-data: writes the scenes and meshes of the project. Same bytes every time.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "data/make/scenes.h"
#include "data/make/shapes.h"
#include "data/make/terrain.h"
#include "formats/files.h"
#include "formats/scene.h"

namespace {

namespace fs = std::filesystem;
using namespace overcast;

struct NamedScene {
  const char* name;
  Scene (*make)();
};

constexpr std::uint64_t kClutterSeed = 1;

constexpr NamedScene kScenes[] = {
    {"sphere_on_plane", makeSphereOnPlane},
    {"cornell_box", makeCornellBox},
    {"cornell_knot", makeCornellKnot},
    {"cornell_star", makeCornellStar},
    {"clutter", makeClutter},
    {"clutter_64", [] { return makeMovingClutter(64, kClutterSeed); }},
    {"room_with_window", makeRoomWithWindow},
    {"stairs_and_thin_walls", makeStairsAndThinWalls},
    {"foliage", makeFoliage},
    {"statue_two_lights", [] { return makeStatueTwoLights(makeStatue(1.3, 72, 112)); }},
    {"sphere_over_plane", makeSphereOverPlane},
};

// Prints the error, if there is one; true when there is none.
template <class T>
bool reported(const Result<T>& result) {
  if (!result.ok()) std::fprintf(stderr, "overcast-make-data: %s\n", message(result.error()).c_str());
  return result.ok();
}

int writeAll(const fs::path& folder) {
  for (const NamedScene& scene : kScenes)
    if (!reported(writeScene(folder / "scenes" / (std::string(scene.name) + ".gltf"), scene.make()))) return 1;
  if (!reported(writeFileAtomically(folder / "scenes" / "terrain.asc", esriGrid(makeMountains())))) return 1;
  const Mesh meshes[] = {makeBox({1.0, 1.0, 1.0}), makeIcosphere(0.5, 3), makeTorus(0.35, 0.15, 48, 20),
                         makeTorusKnot(0.5, 0.1, 2, 3, 160, 12)};
  for (const Mesh& mesh : meshes)
    if (!reported(writeOff(folder / "meshes" / (mesh.name + ".off"), mesh))) return 1;
  return 0;
}

int writeOne(const Scene& scene, const fs::path& file) {
  return reported(writeScene(file, scene)) ? 0 : 1;
}

int writeDefault(const fs::path& meshes, const fs::path& file) {
  std::vector<std::string> notes;
  const Scene scene = makeDefault(meshes, notes);
  for (const std::string& note : notes) std::fprintf(stderr, "overcast-make-data: %s\n", note.c_str());
  return writeOne(scene, file);
}

/// The statue scene with a mesh of one's own, as tall as ours.
int writeStatue(const fs::path& meshFile, const fs::path& file) {
  Result<MeshFile> read = readMesh(meshFile);
  if (!reported(read)) return 1;
  Mesh mesh = std::move(read).value().mesh;
  fitToSize(mesh, 1.3);
  return writeOne(makeStatueTwoLights(std::move(mesh)), file);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Writes the scenes and meshes of the project. Exit codes: 0 done, 1 a file cannot be written, others: bad arguments.");
  app.require_subcommand(1);
  fs::path output, meshes;
  int objects = 0;
  std::uint64_t seed = kClutterSeed;
  CLI::App* all = app.add_subcommand("all", "scenes/*.gltf and meshes/*.off, as committed in data/");
  all->add_option("-o,--output", output, "folder to write into")->required();
  CLI::App* standard = app.add_subcommand("default", "the scene of the demo, with scanned meshes");
  standard->add_option("--meshes", meshes, "folder that holds elephant.off, bunny00.off and armadillo.off")->required();
  standard->add_option("-o,--output", output, ".gltf file to write")->required();
  CLI::App* statue = app.add_subcommand("statue", "statue_two_lights with another mesh for a statue, y up");
  statue->add_option("--mesh", meshes, "OBJ, PLY, STL or OFF")->required();
  statue->add_option("-o,--output", output, ".gltf file to write")->required();
  CLI::App* clutter = app.add_subcommand("clutter", "objects that all move, over a slab");
  clutter->add_option("--objects", objects, "how many")->required()->check(CLI::Range(1, 4096));
  CLI::App* random = app.add_subcommand("random", "a scene by chance, to fit constants on or to test with");
  for (CLI::App* command : {clutter, random}) {
    command->add_option("--seed", seed, "the same one gives the same scene")->capture_default_str();
    command->add_option("-o,--output", output, ".gltf file to write")->required();
  }
  CLI11_PARSE(app, argc, argv);
  if (clutter->parsed()) return writeOne(makeMovingClutter(objects, seed), output);
  if (random->parsed()) return writeOne(makeRandomScene(seed), output);
  if (statue->parsed()) return writeStatue(meshes, output);
  return all->parsed() ? writeAll(output) : writeDefault(meshes, output);
}
