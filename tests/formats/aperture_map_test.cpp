// Aperture maps: mipmap levels and filtering against what light does, files, damage, and texture coordinates of glTF.
#include "formats/aperture_map.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "formats/files.h"
#include "formats/scene.h"
#include "tests/formats/gltf_builder.h"
#include "tests/formats/support.h"

namespace overcast {
namespace {

using testing::HasSubstr;

constexpr double kPi = 3.14159265358979323846;

ApertureMap randomMap(glm::ivec2 size, unsigned seed, double coveredShare = 1.0) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<float>(random()) * 0x1p-32f; };
  ApertureMap map{size, {{}}, 1};
  for (int i = 0; i < size.x * size.y; ++i) {
    const glm::vec3 direction = glm::normalize(glm::vec3(uniform() - 0.5f, 0.3f + uniform(), uniform() - 0.5f));
    const bool covered = static_cast<double>(uniform()) < coveredShare;
    map.levels[0].push_back({{direction, 1.57f * uniform()}, uniform(), covered ? 0.1f + 0.9f * uniform() : 0.0f});
  }
  buildLevels(map);
  return map;
}

bool same(const ApertureTexel& a, const ApertureTexel& b) {
  return a.aperture.direction == b.aperture.direction && a.aperture.radius == b.aperture.radius && a.ambient == b.ambient &&
         a.coverage == b.coverage;
}

TEST(ApertureMap, AnOpenMapIsOpenOnEveryLevelAndOnDisk) {
  for (const glm::ivec2 size : {glm::ivec2(64, 64), glm::ivec2(37, 10), glm::ivec2(1, 5)}) {
    const glm::vec3 up = glm::normalize(glm::vec3(0.3f, 0.8f, -0.2f));
    ApertureMap map{size, {std::vector<ApertureTexel>(static_cast<std::size_t>(size.x * size.y), {{up, capRadius(1.0)}, 1.0f, 1.0f})}, 1};
    buildLevels(map);
    ASSERT_TRUE(isWhole(map));
    for (const std::vector<ApertureTexel>& level : asStored(map).levels)
      for (const ApertureTexel& texel : level) {
        EXPECT_EQ(texel.aperture.radius, capRadius(1.0));
        EXPECT_EQ(texel.ambient, 1.0f);
        EXPECT_EQ(texel.coverage, 1.0f);
        EXPECT_LT(glm::length(texel.aperture.direction - up), 1e-3f);
      }
  }
}

/// Sums over the texels of a level, as shares of the whole map, computed here from the definition of a cap.
struct Totals {
  double coverage = 0.0, solidAngle = 0.0, ambient = 0.0;
};

Totals totals(const ApertureMap& map, std::size_t level) {
  Totals sum;
  const double texels = static_cast<double>(map.levels[level].size());
  for (const ApertureTexel& texel : map.levels[level]) {
    const double weight = double{texel.coverage} / texels;
    sum.coverage += weight;
    sum.solidAngle += weight * 2.0 * kPi * (1.0 - std::cos(double{texel.aperture.radius}));
    sum.ambient += weight * double{texel.ambient};
  }
  return sum;
}

TEST(ApertureMap, LevelsKeepTheLightOfTheSurfaceForAnySize) {
  for (const glm::ivec2 size : {glm::ivec2(32, 32), glm::ivec2(64, 16), glm::ivec2(45, 31), glm::ivec2(7, 3)}) {
    const ApertureMap map = randomMap(size, 3, 0.6);
    ASSERT_TRUE(isWhole(map));
    const Totals finest = totals(map, 0);
    for (std::size_t l = 1; l < map.levels.size(); ++l) {
      const Totals level = totals(map, l);
      EXPECT_NEAR(level.coverage, finest.coverage, 1e-5) << size.x << " x " << size.y << " level " << l;
      EXPECT_NEAR(level.solidAngle, finest.solidAngle, 1e-5);
      EXPECT_NEAR(level.ambient, finest.ambient, 1e-5);
    }
  }
}

TEST(ApertureMap, TexelsOffTheSurfaceDoNotBleedIntoLevels) {
  ApertureMap dirty = randomMap({16, 16}, 5, 0.5), clean = dirty;
  for (ApertureTexel& texel : dirty.levels[0])
    if (texel.coverage == 0.0f) texel = {{glm::vec3(0.0f, -1.0f, 0.0f), 0.0f}, 0.0f, 0.0f};
  buildLevels(dirty);
  for (std::size_t l = 1; l < clean.levels.size(); ++l)
    for (std::size_t i = 0; i < clean.levels[l].size(); ++i)
      if (clean.levels[l][i].coverage > 0.0f) {
        EXPECT_TRUE(same(dirty.levels[l][i], clean.levels[l][i]));
      }
}

TEST(ApertureMap, DirectionsAreWeighedByWhatIsVisibleThere) {
  const glm::vec3 x(1, 0, 0), y(0, 1, 0);
  ApertureMap map{{2, 1}, {{{{x, 0.5f}, 0.2f, 1.0f}, {{y, 1.0f}, 0.6f, 1.0f}}}, 1};
  buildLevels(map);
  const double a = 1.0 - std::cos(0.5), b = 1.0 - std::cos(1.0);
  const ApertureTexel& mean = map.levels[1][0];
  EXPECT_NEAR(mean.aperture.direction.x / mean.aperture.direction.y, a / b, 1e-6);
  EXPECT_NEAR(mean.aperture.radius, std::acos(1.0 - 0.5 * (a + b)), 1e-6);
  EXPECT_NEAR(mean.ambient, 0.4f, 1e-6);
  // Shut texels keep a direction.
  map.levels[0] = {{{x, 0.0f}, 0.0f, 1.0f}, {{x, 0.0f}, 0.0f, 1.0f}};
  buildLevels(map);
  EXPECT_EQ(map.levels[1][0].aperture.direction, x);
  EXPECT_EQ(map.levels[1][0].aperture.radius, 0.0f);
}

TEST(ApertureMap, SamplesAreBilinearAndClampToEdges) {
  ApertureMap map = randomMap({8, 4}, 9);
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 8; ++i)
      map.levels[0][static_cast<std::size_t>(i + 8 * j)].ambient = 0.1f * static_cast<float>(i) + 0.05f * static_cast<float>(j);
  // Linear in u and v between the middles of texels.
  EXPECT_NEAR(sampleApertureMap(map, {3.5 / 8, 1.5 / 4}).ambient, 0.35f, 1e-6);
  EXPECT_NEAR(sampleApertureMap(map, {4.25 / 8, 2.0 / 4}).ambient, 0.375f + 0.075f, 1e-6);
  EXPECT_NEAR(sampleApertureMap(map, {0.0, 0.0}).ambient, 0.0f, 1e-6);
  EXPECT_NEAR(sampleApertureMap(map, {7.0, 1.5 / 4}).ambient, 0.75f, 1e-6);
}

TEST(ApertureMap, FilesComeBackAsStored) {
  const TemporaryFolder folder;
  for (const glm::ivec2 size : {glm::ivec2(64, 64), glm::ivec2(100, 30), glm::ivec2(1, 1)}) {
    ApertureMap map = randomMap(size, 1, 0.7);
    map.usableLevels = static_cast<int>(map.levels.size());
    const auto bytes = writeApertureMap(folder / "map.exr", map);
    ASSERT_TRUE(bytes) << message(bytes.error());
    EXPECT_EQ(bytes.value(), std::filesystem::file_size(folder / "map.exr"));
    EXPECT_EQ(fileBytes(folder / "map.exr"), encodeApertureMap(map));
    const auto back = readApertureMap(folder / "map.exr");
    ASSERT_TRUE(back) << message(back.error());
    const ApertureMap stored = asStored(map);
    EXPECT_EQ(back.value().usableLevels, map.usableLevels);
    ASSERT_EQ(back.value().levels.size(), map.levels.size());
    for (std::size_t l = 0; l < map.levels.size(); ++l)
      for (std::size_t i = 0; i < map.levels[l].size(); ++i) {
        const ApertureTexel &a = back.value().levels[l][i], &b = stored.levels[l][i], &c = map.levels[l][i];
        ASSERT_TRUE(same(a, b));
        ASSERT_NEAR(b.aperture.radius, c.aperture.radius, 0.0004);
        ASSERT_NEAR(b.ambient, c.ambient, 0.00025);
        ASSERT_LT(glm::length(b.aperture.direction - c.aperture.direction), 0.0006f);
      }
  }
}

TEST(ApertureMap, FilesThatAreSomethingElseAreErrors) {
  const TemporaryFolder folder;
  const auto errorOf = [&](const MipmappedImage& image) {
    EXPECT_TRUE(writeMipmaps(folder / "map.exr", image));
    const auto read = readApertureMap(folder / "map.exr");
    return read ? std::string() : message(read.error());
  };
  const MipmappedImage whole = imageOf(randomMap({8, 8}, 2));
  EXPECT_EQ(errorOf(whole), "");
  MipmappedImage image = whole;
  image.numbers.erase("overcast_version");
  EXPECT_THAT(errorOf(image), HasSubstr("map.exr: overcast_version: is missing, this is no aperture map"));
  image = whole;
  image.numbers["overcast_version"] = kApertureMapVersion + 1;
  EXPECT_THAT(errorOf(image), HasSubstr("overcast_version: is 2, this program reads 1 to 1"));
  image = whole;
  image.numbers["overcast_usable_levels"] = 5;
  EXPECT_THAT(errorOf(image), HasSubstr("overcast_usable_levels: is 5"));
  image = whole;
  for (Image& level : image.levels) level.channels[5] = "depth";
  EXPECT_THAT(errorOf(image), HasSubstr("channels: radius is missing"));
  for (std::size_t channel = 0; channel < 6; ++channel) {
    image = whole;
    image.levels[1].pixels[6 * 3 + channel] = 1.5f;
    EXPECT_THAT(errorOf(image), HasSubstr("out of range")) << channel;
  }
  EXPECT_FALSE(readApertureMap(folder / "missing.exr"));
}

TEST(ApertureMap, DamagedFilesAreErrorsOrWhole) {
  const TemporaryFolder folder;
  const std::vector<std::byte> whole = encodeApertureMap(randomMap({16, 16}, 4));
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    putBytes(folder / "map.exr", mutated(whole, seed));
    const auto read = readApertureMap(folder / "map.exr");
    if (read) {
      EXPECT_TRUE(isWhole(read.value()));
    } else {
      EXPECT_THAT(message(read.error()), HasSubstr("map.exr"));
      ++refused;
    }
  }
  EXPECT_GT(refused, 30);
}

TEST(ApertureMap, ALinkFindsItsFileInsideTheFolderOnly) {
  const TemporaryFolder folder;
  const ApertureMap map = randomMap({4, 4}, 6);
  ASSERT_TRUE(writeApertureMap(folder / "a b.exr", map));
  ApertureLink link{"a b.exr", contentHash(encodeApertureMap(map)), 0, 0, false, -1.0, -1.0, -1.0};
  EXPECT_TRUE(readApertureMap(folder / "", link));
  link.contentHash[0] = link.contentHash[0] == '0' ? '1' : '0';
  EXPECT_THAT(message(readApertureMap(folder / "", link).error()), HasSubstr("content hash"));
  link.uri = "../a b.exr";
  EXPECT_FALSE(readApertureMap(folder / "", link));
}

/// A triangle with texture coordinates in these numbers of a component type.
template <class T>
test::GltfBuilder mappedTriangle(const std::vector<T>& numbers, int componentType, bool normalized, const char* attribute) {
  test::GltfBuilder builder;
  builder.show(builder.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3));
  const int view = builder.view(numbers);
  const int accessor = builder.accessor({{"bufferView", view}, {"componentType", componentType}, {"count", 3}, {"type", "VEC2"}});
  if (normalized) builder.json["accessors"][static_cast<std::size_t>(accessor)]["normalized"] = true;
  builder.json["meshes"][0]["primitives"][0]["attributes"][attribute] = accessor;
  return builder;
}

std::vector<glm::vec2> coordinatesOf(const test::GltfBuilder& builder) {
  const TemporaryFolder folder;
  const auto scene = readScene(builder.gltf(folder / ""));
  EXPECT_TRUE(scene) << message(scene.error());
  return scene ? scene.value().meshes[0].textureCoordinates : std::vector<glm::vec2>{};
}

TEST(TextureCoordinates, AreReadFromFloatsAndNormalisedIntegers) {
  const std::vector<glm::vec2> expected{{0, 1}, {1, 0}, {0.2f, 0.6f}};
  EXPECT_EQ(coordinatesOf(mappedTriangle<float>({0, 1, 1, 0, 0.2f, 0.6f}, 5126, false, "TEXCOORD_0")), expected);
  EXPECT_EQ(coordinatesOf(mappedTriangle<std::uint8_t>({0, 255, 255, 0, 51, 153}, 5121, true, "TEXCOORD_0")), expected);
  EXPECT_EQ(coordinatesOf(mappedTriangle<std::uint16_t>({0, 65535, 65535, 0, 13107, 39321}, 5123, true, "TEXCOORD_0")), expected);
  EXPECT_TRUE(coordinatesOf(mappedTriangle<float>({0, 1, 1, 0, 0.2f, 0.6f}, 5126, false, "TEXCOORD_1")).empty());
  EXPECT_TRUE(coordinatesOf(mappedTriangle<float>({0, 1, 1, 0, NAN, 0.6f}, 5126, false, "TEXCOORD_0")).empty());
}

TEST(TextureCoordinates, AnApertureMapNamesItsSet) {
  test::GltfBuilder builder = mappedTriangle<float>({0, 1, 1, 0, 0.2f, 0.6f}, 5126, false, "TEXCOORD_3");
  builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = builder.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  builder.json["meshes"][0]["extensions"]["OVERCAST_aperture"] = {
      {"version", 1}, {"uri", "m.exr"}, {"contentHash", ""}, {"bytes", 5}, {"texCoord", 3}};
  const TemporaryFolder folder;
  auto scene = readScene(builder.gltf(folder / ""));
  ASSERT_TRUE(scene) << message(scene.error());
  const Mesh& mesh = scene.value().meshes[0];
  ASSERT_EQ(mesh.textureCoordinates.size(), 3u);
  ASSERT_TRUE(mesh.apertureMap);
  EXPECT_EQ(mesh.apertureMap->uri, "m.exr");
  EXPECT_EQ(mesh.apertureMap->texCoord, 0);
  builder.json["meshes"][0]["extensions"]["OVERCAST_aperture"]["texCoord"] = 0;
  scene = readScene(builder.gltf(folder / ""));
  ASSERT_TRUE(scene);
  EXPECT_FALSE(scene.value().meshes[0].apertureMap);
  ASSERT_EQ(scene.value().notes.size(), 1u);
  EXPECT_THAT(scene.value().notes[0], HasSubstr("aperture map"));
}

}  // namespace
}  // namespace overcast
