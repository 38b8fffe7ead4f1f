// Damaged glTF files: whatever the bytes are, reading ends in a scene that keeps its invariants or in an Error.
#include <fstream>
#include <iterator>
#include <random>

#include <gtest/gtest.h>

#include "formats/scene.h"
#include "formats/scene_check.h"
#include "tests/formats/gltf_builder.h"
#include "tests/formats/random_scene.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using test::GltfBuilder;

std::string contentOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// One to four damages: flipped bytes, other digits, text taken out, doubled, or cut off.
std::string damaged(std::string bytes, std::mt19937_64& dice) {
  for (std::uint64_t left = 1 + dice() % 4; left > 0 && !bytes.empty(); --left) {
    const std::size_t at = dice() % bytes.size();
    const std::size_t length = 1 + dice() % 40;
    switch (dice() % 6) {
      case 0:
        bytes[at] = static_cast<char>(dice());
        break;
      case 1:
        for (std::size_t i = at; i < std::min(at + length, bytes.size()); ++i)
          if (bytes[i] >= '0' && bytes[i] <= '9') bytes[i] = static_cast<char>('0' + dice() % 10);
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(at, bytes.substr(dice() % bytes.size(), length));
        break;
      case 4:
        if (dice() % 8 == 0) bytes.resize(at);
        break;
      default: {
        const std::size_t digit = bytes.find_first_of("0123456789", at);
        if (digit != std::string::npos) bytes.replace(digit, 1, dice() % 2 == 0 ? "-1" : "4294967297");
      }
    }
  }
  return bytes;
}

/// Counts of scenes read and refused; fails on a scene that breaks its invariants.
struct Outcome {
  int read = 0;
  int refused = 0;
};

void tryFile(const std::filesystem::path& path, int mutation, Outcome& outcome) {
  auto scene = readScene(path);
  if (scene) {
    EXPECT_EQ(brokenInvariant(scene.value()), "") << "mutation " << mutation;
    (void)worldBounds(scene.value());
    ++outcome.read;
  } else {
    EXPECT_FALSE(scene.error().reason.empty()) << "mutation " << mutation;
    ++outcome.refused;
  }
}

TEST(SceneMutation, DamagedGltfEndsInASceneOrAnError) {
  const test::TemporaryFolder folder;
  std::mt19937_64 dice(20);
  Outcome outcome;
  for (int i = 0; i < 150; ++i) {
    const auto path = folder.path / "scene.gltf";
    if (i % 10 == 0) {
      ASSERT_TRUE(writeScene(folder.path / "whole.gltf", test::randomScene(dice())));
    }
    const std::string json = contentOf(folder.path / "whole.gltf");
    GltfBuilder::save(path, i % 5 == 4 ? json : damaged(json, dice));
    if (i % 5 == 4) GltfBuilder::save(folder.path / "whole.bin", damaged(contentOf(folder.path / "whole.bin"), dice));
    tryFile(path, i, outcome);
  }
  EXPECT_GT(outcome.read, 10);
  EXPECT_GT(outcome.refused, 10);
}

TEST(SceneMutation, DamagedGlbEndsInASceneOrAnError) {
  const test::TemporaryFolder folder;
  GltfBuilder builder = GltfBuilder::triangle();
  const int what = builder.view(std::vector<float>{4, 5, 6});
  const int where = builder.view(std::vector<std::uint8_t>{1});
  const nlohmann::ordered_json sparse = {
      {"count", 1}, {"indices", {{"bufferView", where}, {"componentType", 5121}}}, {"values", {{"bufferView", what}}}};
  builder.show(builder.accessor({{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}, {"sparse", sparse}}), -1, 5);
  builder.json["nodes"][0]["children"] = {2};
  builder.json["nodes"].push_back({{"matrix", {1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3, 0, 4, 5, 6, 1}}});
  const int times = builder.floats({0, 1}, 1);
  const int values = builder.floats({0, 0, 0, 1, 0, 1, 0, 1}, 4);
  builder.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}}},
                                 {"samplers", {{{"input", times}, {"output", values}}}}}};
  const std::string whole = builder.glbBytes();
  std::mt19937_64 dice(21);
  Outcome outcome;
  for (int i = 0; i < 150; ++i) {
    GltfBuilder::save(folder.path / "scene.glb", damaged(whole, dice));
    tryFile(folder.path / "scene.glb", i, outcome);
  }
  EXPECT_GT(outcome.read, 10);
  EXPECT_GT(outcome.refused, 10);
}

}  // namespace
}  // namespace overcast
