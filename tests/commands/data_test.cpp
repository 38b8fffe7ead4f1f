// The scenes and meshes in data/ are what the program makes, and sound: closed, facing outwards, standing on their ground, looping.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "formats/scene.h"
#include "tests/commands/scratch.h"
#include "tests/commands/shell.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kData = fs::path(OVERCAST_SOURCE_FOLDER) / "data";
const std::string kMakeData = quoted((fs::path(OVERCAST_BINARY_FOLDER) / "overcast-make-data").string());

std::string contents(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(MakeData, MakesWhatIsCommittedByteForByte) {
  const fs::path folder = scratchFolder();
  const auto made = shell(kMakeData + " all -o " + quoted(folder.string()));
  ASSERT_EQ(made.exitCode, 0) << made.output;
  std::size_t files = 0;
  for (const char* room : {"scenes", "meshes"}) {
    for (const auto& entry : fs::directory_iterator(kData / room)) {
      ++files;
      EXPECT_TRUE(contents(entry.path()) == contents(folder / room / entry.path().filename()))
          << entry.path() << ": ./run data makes it anew";
    }
    for (const auto& entry : fs::directory_iterator(folder / room))
      EXPECT_TRUE(fs::exists(kData / room / entry.path().filename())) << entry.path();
  }
  EXPECT_EQ(files, 27u);
}

TEST(MakeData, DefaultSceneDoesWithoutScannedMeshes) {
  const fs::path folder = scratchFolder();
  const auto made =
      shell(kMakeData + " default --meshes " + quoted((folder / "none").string()) + " -o " + quoted((folder / "default.gltf").string()));
  EXPECT_EQ(made.exitCode, 0) << made.output;
  EXPECT_THAT(made.output, HasSubstr("elephant.off"));
  EXPECT_THAT(made.output, HasSubstr("a torus knot takes its place"));
  const auto scene = readScene(folder / "default.gltf");
  ASSERT_TRUE(scene.ok()) << message(scene.error());
  EXPECT_GE(scene.value().meshes.size(), 8u);
}

TEST(MakeData, SaysWhatItCannotWrite) {
  const auto made = shell(kMakeData + " all -o /proc/overcast");
  EXPECT_EQ(made.exitCode, 1);
  EXPECT_THAT(made.output, HasSubstr("overcast-make-data: /proc/overcast"));
}

// Every mesh: each edge is met as often in one direction as in the other, and the volume is that of an inside.
void expectClosedAndFacingOutwards(const Scene& scene) {
  for (const Mesh& mesh : scene.meshes) {
    using Point = std::array<double, 3>;
    std::map<std::pair<Point, Point>, int> edges;
    double volume = 0.0;
    for (const glm::uvec3& t : mesh.triangles) {
      const std::array<glm::dvec3, 3> p = {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
      volume += glm::dot(p[0], glm::cross(p[1], p[2])) / 6.0;
      for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec3 a = p[i], b = p[(i + 1) % 3];
        ++edges[{{a.x, a.y, a.z}, {b.x, b.y, b.z}}];
        --edges[{{b.x, b.y, b.z}, {a.x, a.y, a.z}}];
      }
    }
    EXPECT_GT(volume, 0.0) << mesh.name;
    for (const auto& [edge, count] : edges) ASSERT_EQ(count, 0) << mesh.name << " is open";
  }
}

// What the program makes of `arguments`; the .bin, whose name is a hash of its content, is beside it.
Scene generated(const std::string& arguments, const fs::path& file) {
  const auto made = shell(kMakeData + " " + arguments + " -o " + quoted(file.string()));
  EXPECT_EQ(made.exitCode, 0) << made.output;
  auto scene = readScene(file);
  EXPECT_TRUE(scene.ok()) << message(scene.error());
  return scene.ok() ? std::move(scene).value() : Scene{};
}

TEST(MakeData, ClutterIsAsManyMovingObjectsAsAskedForThatNeverMeet) {
  const fs::path folder = scratchFolder();
  for (const int objects : {1, 300}) {
    const Scene scene = generated(fmt::format("clutter --objects {} --seed 5", objects), folder / "clutter.gltf");
    ASSERT_EQ(scene.nodes.size(), static_cast<std::size_t>(objects) + 2u) << "ground and camera besides";
    ASSERT_EQ(scene.animations.size(), 1u);
    EXPECT_EQ(scene.animations[0].channels.size(), static_cast<std::size_t>(objects));
    for (const double time : {0.0, 0.3, 0.75, 1.4}) {
      const auto world = worldFromLocal(scene, time);
      std::vector<glm::dvec4> spheres;
      for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
        if (scene.nodes[i].mesh < 0 || scene.nodes[i].name == "ground") continue;
        double radius = 0.0;
        for (const glm::dvec3& position : scene.meshes[static_cast<std::size_t>(scene.nodes[i].mesh)].positions)
          radius = std::max(radius, glm::length(glm::dvec3(world[i] * glm::dvec4(position, 0.0))));
        spheres.emplace_back(glm::dvec3(world[i][3]), radius);
      }
      for (std::size_t a = 0; a < spheres.size(); ++a)
        for (std::size_t b = 0; b < a; ++b)
          ASSERT_GT(glm::distance(glm::dvec3(spheres[a]), glm::dvec3(spheres[b])), spheres[a].w + spheres[b].w - 1e-5)
              << a << " meets " << b;
    }
  }
  EXPECT_NE(shell(kMakeData + " clutter --objects 0 -o x.gltf").exitCode, 0);
}

TEST(MakeData, RandomScenesAreSoundAndFollowFromTheirSeed) {
  const fs::path folder = scratchFolder();
  std::map<std::string, int> different;
  for (int seed = 0; seed < 12; ++seed) {
    const std::string arguments = fmt::format("random --seed {}", seed);
    const Scene scene = generated(arguments, folder / "a" / "scene.gltf");
    generated(arguments, folder / "b" / "scene.gltf");
    const std::string text = contents(folder / "a" / "scene.gltf");
    EXPECT_EQ(text, contents(folder / "b" / "scene.gltf"));
    ++different[text];
    EXPECT_EQ(scene.cameras.size(), 1u);
    EXPECT_GE(scene.nodes.size(), 6u) << seed;
    const glm::dvec3 size = extent(worldBounds(scene));
    EXPECT_GT(size.x, 0.2) << seed;
    EXPECT_LT(size.x, 80.0) << seed;
    expectClosedAndFacingOutwards(scene);
  }
  EXPECT_EQ(different.size(), 12u);
}

class DataScene : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    auto read = readScene(kData / "scenes" / (std::string(GetParam()) + ".gltf"));
    ASSERT_TRUE(read.ok()) << message(read.error());
    scene = std::move(read).value();
  }
  Scene scene;
};

TEST_P(DataScene, MeshesAreClosedAndFaceOutwards) {
  expectClosedAndFacingOutwards(scene);
}

// What others stand on or in.
constexpr std::array<std::string_view, 7> kShell = {"ground", "floor", "ceiling", "left", "right", "back", "front"};

TEST_P(DataScene, NothingSinksIntoTheGround) {
  for (const double time : {0.0, 0.4, 0.9, 1.5}) {
    const auto world = worldFromLocal(scene, time);
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
      const Node& node = scene.nodes[i];
      const bool isShell = std::find(kShell.begin(), kShell.end(), node.name) != kShell.end();
      if (node.mesh < 0 || isShell || extent(bounds(scene.meshes[static_cast<std::size_t>(node.mesh)])).y < 0.2) continue;
      for (const glm::dvec3& position : scene.meshes[static_cast<std::size_t>(node.mesh)].positions)
        ASSERT_GT((world[i] * glm::dvec4(position, 1.0)).y, -1e-4) << node.name << " at " << time;
    }
  }
}

TEST_P(DataScene, LoopsWithoutAJump) {
  EXPECT_LE(animationDuration(scene), 2.0);
  const auto first = worldFromLocal(scene, 0.0), last = worldFromLocal(scene, animationDuration(scene), false);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].mesh < 0) continue;
    // A cube turned by 90 degrees and a wheel turned by 180 are back where they were: compare their boxes in the world.
    Box before, after;
    for (const glm::dvec3& position : scene.meshes[static_cast<std::size_t>(scene.nodes[i].mesh)].positions) {
      include(before, glm::dvec3(first[i] * glm::dvec4(position, 1.0)));
      include(after, glm::dvec3(last[i] * glm::dvec4(position, 1.0)));
    }
    EXPECT_LT(glm::length(before.min - after.min) + glm::length(before.max - after.max), 1e-4) << scene.nodes[i].name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, DataScene,
                         testing::Values("sphere_on_plane", "cornell_box", "cornell_knot", "cornell_star", "clutter", "clutter_64",
                                         "room_with_window", "stairs_and_thin_walls", "foliage", "statue_two_lights", "sphere_over_plane"));

}  // namespace
}  // namespace overcast::test
