// Radius fields: cube map convention, distance against closed forms and its bounds, files.
#include "formats/radius.h"

#include <cmath>
#include <fstream>
#include <random>
#include <set>

#include <ImfEnvmap.h>
#include <ImfInputFile.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "formats/asset.h"
#include "formats/image_mipmaps.h"
#include "formats/shared/cube_map.h"
#include "tests/formats/radius_fields.h"
#include "tests/formats/support.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using reference::RadiusFunction;
using test::fieldOf;

const RadiusFunction kUnitSphere = [](const glm::dvec3&) { return 1.0; };

glm::dvec3 randomUnit(std::mt19937& random) {
  const auto uniform = [&] { return static_cast<double>(random()) / 2147483648.0 - 1.0; };
  for (;;) {
    const glm::dvec3 p(uniform(), uniform(), uniform());
    if (glm::length(p) > 0.01 && glm::length(p) < 1.0) return glm::normalize(p);
  }
}

std::vector<std::pair<const char*, RadiusField>> shapes() {
  return {{"sphere", fieldOf(kUnitSphere, 8)},
          {"off-centre", fieldOf(reference::sphereRadius({0.6, -0.2, 0.3}, 1.0), 16, {5.0, -3.0, 1.0})},
          {"ellipsoid", fieldOf(reference::ellipsoidRadius({1.0, 0.3, 0.5}), 32)},
          {"cube", fieldOf(reference::cuboidRadius({1.0, 0.7, 0.9}), 16)},
          {"bumpy", fieldOf(reference::bumpyRadius(), 16, glm::dvec3(0.0), 0.01f)}};
}

TEST(CubeMap, FacesAreInVulkansOrderAndTurn) {
  // Vulkan 1.3, table "Cube map face and coordinate selection": for +x, s and t run along -z and -y, and so on.
  const glm::vec3 right[] = {{0, 0, -1}, {0, 0, 1}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {-1, 0, 0}};
  const glm::vec3 down[] = {{0, -1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {0, -1, 0}, {0, -1, 0}};
  const glm::vec3 main[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (unsigned face = 0; face < 6; ++face) {
    const glm::vec3 d = shared::cubeDirection(face, {0.25f, -0.5f});
    EXPECT_EQ(d, main[face] + 0.25f * right[face] - 0.5f * down[face]);
    EXPECT_EQ(shared::cubeFace(3.0f * d), face);
    EXPECT_EQ(shared::cubeCoordinates(face, 4.0f * d), glm::vec2(0.25f, -0.5f));
  }
  EXPECT_EQ(shared::cubeCoordinates(shared::cubeFace(glm::vec3(0.0f)), glm::vec3(0.0f)), glm::vec2(0.0f));
}

TEST(CubeMap, TexelsOnEdgesAndCornersStandForOnePlaceEach) {
  const int n = 8;
  std::set<std::size_t> places;
  for (unsigned face = 0; face < 6; ++face)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) places.insert(texelTowards(n, texelDirection(n, face, i, j)));
  // The surface lattice of a cube: 8 corners, 12 edges, 6 faces.
  EXPECT_EQ(places.size(), 8u + 12u * (n - 2) + 6u * (n - 2) * (n - 2));
}

TEST(Radius, SphereAboutItsCentreIsExactEverywhereInTheBox) {
  for (const double scale : {1e-4, 1.0, 1e4}) {
    const glm::dvec3 centre = glm::dvec3(3.0, -1.0, 2.0) * scale;
    const RadiusField field = fieldOf([&](const glm::dvec3&) { return scale; }, 8, centre);
    const Box box = bounds(field);
    for (const glm::dvec3& p : reference::randomPoints(box, 500, 1))
      EXPECT_NEAR(sampleRadius(field, p), glm::length(p - centre) - scale, 2e-7 * scale);
    EXPECT_NEAR(sampleRadius(field, centre), -scale, 1e-7 * scale);
    EXPECT_NEAR(lipschitzBound(field), 1.0, 1e-6);
    EXPECT_NEAR(box.max.x - centre.x, (1.0 + kRadiusPadding) * scale, 0.05 * scale);
  }
}

/// The distance of the closest of many points of the surface, refined about the best of a coarse lattice of directions.
double searchedByForce(const RadiusFunction& radius, const glm::dvec3& p) {
  const auto squared = [&](const glm::dvec3& d) {
    const glm::dvec3 unit = glm::normalize(d), apart = p - radius(unit) * unit;
    return glm::dot(apart, apart);
  };
  glm::dvec3 best(1.0, 0.0, 0.0);
  for (unsigned face = 0; face < 6; ++face)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i)
        if (const glm::dvec3 d = texelDirection(24, face, i, j); squared(d) < squared(best)) best = glm::normalize(d);
  for (double step = 0.1; step > 1e-7; step *= 0.5)
    for (bool moved = true; moved;) {
      moved = false;
      for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
          glm::dvec3 other = best;
          other[axis] += sign * step;
          if (squared(other) >= squared(best)) continue;
          best = glm::normalize(other);
          moved = true;
        }
    }
  const double distance = std::sqrt(squared(best));
  return glm::length(p) < radius(glm::normalize(p)) ? -distance : distance;
}

TEST(Radius, ErrorFallsWithSizeOnSmoothShapes) {
  const RadiusFunction functions[] = {reference::sphereRadius({0.3, 0.1, -0.2}, 1.0), reference::ellipsoidRadius({1.0, 0.6, 0.8}),
                                      [](const glm::dvec3& d) { return 1.0 + 0.1 * std::sin(3.0 * d.x + 2.0 * d.y + 1.0); }};
  for (const RadiusFunction& radius : functions) {
    std::vector<glm::dvec3> points;
    std::vector<double> exact;
    std::mt19937 random(3);
    for (int n = 0; n < 300; ++n) {
      const glm::dvec3 d = randomUnit(random);
      points.push_back(radius(d) * (0.95 + 0.1 * (n % 11) / 10.0) * d);
      exact.push_back(searchedByForce(radius, points.back()));
    }
    double before = 1e300;
    for (const int side : {8, 16, 32, 64, 128}) {
      const RadiusField field = fieldOf(radius, side);
      double squares = 0.0;
      for (std::size_t n = 0; n < points.size(); ++n) squares += std::pow(sampleRadius(field, points[n]) - exact[n], 2.0);
      const double rms = std::sqrt(squares / static_cast<double>(points.size()));
      EXPECT_LT(rms, side <= 32 ? 0.45 * before : before) << "side " << side << ": second order until the search's own error is left";
      before = rms;
    }
    EXPECT_LT(before, 1e-4);
  }
}

// Far away too the distance is that of the closest point, not of the point below: an elongated body's tip is nearer than its flank.
TEST(Radius, FarDistancesAreSensible) {
  const RadiusFunction radius = reference::ellipsoidRadius({1.0, 0.5, 0.5});
  const RadiusField field = fieldOf(radius, 32);
  std::mt19937 random(5);
  for (int n = 0; n < 300; ++n) {
    const glm::dvec3 p = (1.5 + 0.01 * n) * randomUnit(random);
    const double exact = searchedByForce(radius, p);
    EXPECT_NEAR(sampleRadius(field, p), exact, 0.06 * exact);
  }
}

TEST(Radius, VarianceWidensTheFalloff) {
  const RadiusField smooth = fieldOf(kUnitSphere, 16), rough = fieldOf(kUnitSphere, 16, glm::dvec3(0.0), 1e-3f);
  const glm::dvec3 outside(1.1, 0.02, 0.0), inside(0.9, 0.02, 0.0);
  EXPECT_NEAR(sampleRadius(smooth, outside), 0.1, 1e-3);
  EXPECT_LT(sampleRadius(rough, outside), 0.8 * sampleRadius(smooth, outside));
  EXPECT_GT(sampleRadius(rough, inside), 0.8 * sampleRadius(smooth, inside));
}

TEST(Radius, IsContinuousAcrossAllEdgesAndCornersOfTheCubeAndOfTheBox) {
  for (const auto& [name, field] : shapes()) {
    const Box box = bounds(field);
    const double size = diagonal(box), slope = lipschitzBound(field);
    for (int level = 0; level < 3; ++level)
      for (int i = 0; i < 200; ++i) {
        // The point at i / 200 along each of the 12 edges, which ends in two corners.
        for (int edge = 0; edge < 12; ++edge) {
          glm::dvec3 d;
          d[edge % 3] = -1.0 + 2.0 * i / 199.0;
          d[(edge + 1) % 3] = edge / 3 % 2 ? 1.0 : -1.0;
          d[(edge + 2) % 3] = edge / 6 ? 1.0 : -1.0;
          const glm::dvec3 p = field.centre + 0.45 * glm::normalize(d);
          const double here = sampleRadius(field, p, level);
          for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 q = p;
            q[axis] += 1e-9 * size;
            ASSERT_NEAR(sampleRadius(field, q, level), here, 1e-6 * size) << name << " level " << level << " edge " << edge;
          }
        }
      }
    for (const glm::dvec3& p : reference::randomPoints(box, 300, 2))
      for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 inner = p, outer = p;
        inner[axis] = box.max[axis];
        outer[axis] = box.max[axis] + 1e-9 * size;
        ASSERT_NEAR(sampleRadius(field, inner), sampleRadius(field, outer), (1e-8 * slope + 1e-6) * size) << name;
      }
  }
}

TEST(Radius, IsNeverNegativeOnTheBorderOfTheBoxAtAnyLevel) {
  for (const auto& [name, field] : shapes())
    for (std::size_t l = 0; l < field.levels.size(); ++l) {
      const Box& box = field.levels[l].box;
      for (glm::dvec3 p : reference::randomPoints(box, 300, 9))
        for (int axis = 0; axis < 3; ++axis) {
          glm::dvec3 q = p;
          q[axis] = (l + static_cast<std::size_t>(axis)) % 2 ? box.max[axis] : box.min[axis];
          ASSERT_GE(sampleRadius(field, field.centre + q, static_cast<int>(l)), 0.0) << name << " level " << l;
        }
    }
}

TEST(Radius, LiesWithinItsRangeWhichChangesNoFasterThanItsBound) {
  for (const auto& [name, field] : shapes())
    for (std::size_t l = 0; l < field.levels.size(); ++l) {
      const int level = static_cast<int>(l);
      const double bound = lipschitzBound(field, level);
      const Box& box = field.levels[l].box;
      const double size = diagonal(box);
      std::mt19937 random(5);
      glm::dvec2 steepest(0.0);
      for (const glm::dvec3& p : reference::randomPoints({box.min - 0.3 * size, box.max + 0.3 * size}, 4000, 7)) {
        // Half of the points close to the centre, where directions turn fast.
        const glm::dvec3 a = field.centre + (random() % 2 ? p : 0.1 * p);
        const double step = 1e-4 * size;
        const glm::dvec3 b = a + step * randomUnit(random);
        const glm::dvec2 range = radiusRange(field, a, level), other = radiusRange(field, b, level);
        steepest = glm::max(steepest, glm::abs(range - other) / step);
        const double value = sampleRadius(field, a, level);
        ASSERT_GE(value, range.x - 1e-9 * size) << name << " level " << level;
        ASSERT_LE(value, range.y + 1e-9 * size) << name << " level " << level;
        // Outside, the lower bound is that of a distance.
        if (range.x > step) {
          ASSERT_GE(other.x, range.x - step - 1e-9 * size) << name << " level " << level;
        }
      }
      EXPECT_LE(std::max(steepest.x, steepest.y), bound * (1.0 + 1e-6)) << name << " level " << level;
      EXPECT_GE(bound, 1.0);
      EXPECT_LT(bound, 40.0) << name << ": so loose that it culls nothing";
    }
}

TEST(Radius, FilesComeBackAsStored) {
  const TemporaryFolder folder;
  for (const auto& [name, field] : shapes()) {
    ASSERT_TRUE(isWhole(field));
    const auto path = folder / name;
    const auto bytes = writeRadius(path, field);
    ASSERT_TRUE(bytes) << message(bytes.error());
    EXPECT_EQ(bytes.value(), std::filesystem::file_size(path));
    const auto back = readRadius(path);
    ASSERT_TRUE(back) << message(back.error());
    const RadiusField stored = asStored(field);
    EXPECT_EQ(back.value().centre, field.centre);
    ASSERT_EQ(back.value().levels.size(), field.levels.size());
    for (std::size_t l = 0; l < field.levels.size(); ++l) {
      const double range = field.levels[0].largest - field.levels[0].smallest;
      for (std::size_t i = 0; i < field.levels[l].texel.size(); ++i) {
        const RadiusTexel &a = back.value().levels[l].texel[i], &b = stored.levels[l].texel[i], &c = field.levels[l].texel[i];
        ASSERT_EQ(a.mean, b.mean);
        ASSERT_EQ(a.variance, b.variance);
        ASSERT_EQ(a.slope, b.slope);
        // Half floats hold half of the range to 2^-12; single floats the sum.
        ASSERT_NEAR(b.mean, c.mean, range * 0x1p-12 + c.mean * 0x1p-23) << name;
        ASSERT_NEAR(b.variance, c.variance, c.variance * 0x1p-10 + range * range * 0x1p-24) << name;
      }
    }
    const std::vector<std::byte> first = fileBytes(path);
    ASSERT_TRUE(writeRadius(path, field));
    EXPECT_EQ(fileBytes(path), first);
  }
}

TEST(Radius, OpenExrFindsEveryTexelWhereItLooksForItsDirection) {
  const TemporaryFolder folder;
  const RadiusFunction radius = reference::sphereRadius({0.4, -0.3, 0.2}, 1.0);
  ASSERT_TRUE(writeRadius(folder / "map.exr", fieldOf(radius, 16)));
  const Imf::InputFile file((folder / "map.exr").c_str());
  ASSERT_TRUE(Imf::hasEnvmap(file.header()));
  EXPECT_EQ(Imf::envmap(file.header()), Imf::ENVMAP_CUBE);
  const auto image = readExr(folder / "map.exr");
  ASSERT_TRUE(image) << message(image.error());
  const auto number = readMipmaps(folder / "map.exr").value().numbers;
  std::mt19937 random(8);
  for (int n = 0; n < 200; ++n) {
    const glm::dvec3 d = randomUnit(random);
    Imf::CubeMapFace face;
    Imath::V2f inFace;
    const Imath::V3f direction(static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z));
    Imf::CubeMap::faceAndPixelPosition(direction, file.header().dataWindow(), face, inFace);
    const Imath::V2f at = Imf::CubeMap::pixelPosition(face, file.header().dataWindow(), inFace);
    const float stored = overcast::at(image.value(), static_cast<int>(std::lround(at.x)), static_cast<int>(std::lround(at.y)),
                                      channelIndex(image.value(), "radius"));
    // The nearest texel is at most 0.1 rad away, and the radius changes by at most 0.7 per rad.
    EXPECT_NEAR(number.at("overcast_offset") + number.at("overcast_scale") * stored, radius(d), 0.07);
  }
}

TEST(Radius, AssetsAreWrittenSampledAndReadAsRadius) {
  const TemporaryFolder folder;
  const RadiusField field = asStored(fieldOf(reference::bumpyRadius(), 8, {1.0, 2.0, 3.0}));
  Occluder occluder;
  ASSERT_TRUE(writeAsset(folder / "", "rock", field, occluder));
  EXPECT_EQ(occluder.representation, Representation::radius);
  EXPECT_EQ(occluder.uri, "rock.exr");
  EXPECT_EQ(occluder.lipschitz, lipschitzBound(field));
  const auto back = readAsset(folder / "", occluder);
  ASSERT_TRUE(back) << message(back.error());
  EXPECT_EQ(sampleAsset(back.value(), {1.5, 2.0, 3.3}), sampleRadius(field, {1.5, 2.0, 3.3}));
}

TEST(Radius, FilesThatAreSomethingElseAreErrors) {
  const TemporaryFolder folder;
  const auto path = folder / "field.exr";
  ASSERT_TRUE(writeRadius(path, fieldOf(reference::bumpyRadius(), 8)));
  const MipmappedImage whole = readMipmaps(path).value();
  const auto refused = [&](const char* part, const auto& spoil) {
    MipmappedImage image = whole;
    spoil(image);
    EXPECT_TRUE(writeMipmaps(path, image));
    const auto read = readRadius(path);
    ASSERT_FALSE(read) << part;
    EXPECT_NE(message(read.error()).find(part), std::string::npos) << message(read.error());
    EXPECT_NE(message(read.error()).find("field.exr"), std::string::npos);
  };
  refused("is 2, this program reads up to 1", [](MipmappedImage& i) { i.numbers["overcast_version"] = 2; });
  refused("no version", [](MipmappedImage& i) { i.numbers.erase("overcast_version"); });
  refused("not finite", [](MipmappedImage& i) { i.numbers["overcast_centre_y"] = std::nan(""); });
  refused("scale", [](MipmappedImage& i) { i.numbers["overcast_scale"] = -1.0; });
  refused("not positive", [](MipmappedImage& i) { i.numbers["overcast_offset"] = 0.0; });
  refused("factor", [](MipmappedImage& i) {
    i.numbers["overcast_offset"] = 1.0;
    i.numbers["overcast_scale"] = 0.99999;
    i.levels[0].pixels[0] = -1.0f;
    i.levels[0].pixels[2] = 1.0f;
  });
  refused("not a cube map", [](MipmappedImage& i) { i.cube = false; });
  refused("no channel 'variance'", [](MipmappedImage& i) {
    for (Image& level : i.levels) level.channels[1] = "weight";
  });
  putBytes(path, std::vector<std::byte>(100));
  EXPECT_FALSE(readRadius(path));
  EXPECT_FALSE(readRadius(folder / "missing.exr"));
}

TEST(Radius, SidesOutsideTheLimitsAreErrors) {
  const TemporaryFolder folder;
  for (const int side : {4, 12, 256}) {
    MipmappedImage image;
    image.cube = true;
    image.numbers = {{"overcast_version", 1},  {"overcast_offset", 1},   {"overcast_scale", 1},
                     {"overcast_centre_x", 0}, {"overcast_centre_y", 0}, {"overcast_centre_z", 0}};
    for (int l = 0; l < mipmapLevels(side, 6 * side); ++l) {
      Image level{std::max(1, side >> l), std::max(1, (6 * side) >> l), {"radius", "variance"}, {}};
      level.pixels.assign(static_cast<std::size_t>(2 * level.width * level.height), 0.0f);
      image.levels.push_back(level);
    }
    ASSERT_TRUE(writeMipmaps(folder / "side.exr", image));
    const auto read = readRadius(folder / "side.exr");
    ASSERT_FALSE(read);
    EXPECT_NE(message(read.error()).find("texels a side"), std::string::npos) << message(read.error());
  }
}

TEST(Radius, DamagedFilesAreErrorsOrWhole) {
  const TemporaryFolder folder;
  const auto path = folder / "damaged.exr";
  ASSERT_TRUE(writeRadius(path, fieldOf(reference::bumpyRadius(), 8)));
  const std::vector<std::byte> good = fileBytes(path);
  int errors = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    putBytes(path, mutated(good, seed));
    const auto read = readRadius(path);
    errors += read ? 0 : 1;
    if (read) {
      EXPECT_TRUE(isWhole(read.value()));
      EXPECT_TRUE(std::isfinite(sampleRadius(read.value(), {0.1, 0.2, 0.3})));
    }
  }
  EXPECT_GT(errors, 50);
}

}  // namespace
}  // namespace overcast
