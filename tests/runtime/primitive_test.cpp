// Primitives in the composite: the formulas as C++ against brute force, placed under all kinds of transforms, then on the device.
#include "runtime/passes/composite/primitive.h"

#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "runtime/passes/composite/composite_pass.h"
#include "tests/reference/primitive.h"
#include "tests/runtime/scenes.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

glm::dvec3 anyPoint(std::mt19937& random, double reach) {
  return {uniform(random, -reach, reach), uniform(random, -reach, reach), uniform(random, -reach, reach)};
}

glm::dmat4 worldFromUnit(const Primitive& p) {
  return glm::scale(glm::translate(glm::dmat4(1.0), p.centre) * glm::mat4_cast(p.rotation), p.halfExtents);
}

Primitive anyPrimitive(std::mt19937& random) {
  const glm::dquat q(uniform(random, 0.1, 1), uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
  return {random() % 2 ? PrimitiveShape::cuboid : PrimitiveShape::ellipsoid,
          anyPoint(random, 0.5),
          glm::normalize(q),
          {uniform(random, 0.05, 1.0), uniform(random, 0.05, 1.0), uniform(random, 0.05, 1.0)}};
}

TEST(PrimitiveFormulas, EllipsoidsAreWithinTheStatedError) {
  std::mt19937 random(1);
  double worst = 0.0;
  for (int shape = 0; shape < 40; ++shape) {
    const auto side = [&] { return std::pow(10.0, uniform(random, -3.0, 0.0)); };
    glm::dvec3 half(1.0, side(), side());
    if (half.y < half.z) std::swap(half.y, half.z);
    const glm::dmat4 world = glm::scale(glm::dmat4(1.0), glm::dvec3(glm::vec3(half)));
    for (int i = 0; i < 40; ++i) {
      glm::dvec3 p = anyPoint(random, 1.3) * (i % 2 ? half : glm::dvec3(1.0));
      // On planes of symmetry and a hair off them the closest point leaps.
      if (i % 8 < 3) p[i % 8] *= i % 16 < 8 ? 0.0 : 1e-5;
      const glm::vec3 at(p);
      const double expected = reference::ellipsoidDistance(glm::dvec3(at), world);
      const double error = std::abs(static_cast<double>(shared::ellipsoidDistance(at, glm::vec3(half))) - expected);
      worst = std::max(worst, error / (1.0 + std::abs(expected)));
    }
  }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_LT(worst, static_cast<double>(shared::kEllipsoidError));
}

TEST(PrimitiveFormulas, CuboidsAreExactToRounding) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 half = glm::abs(glm::vec3(anyPoint(random, 1.0))) + 0.01f, at(anyPoint(random, 2.0));
    const double expected = reference::cuboidDistance(glm::dvec3(at), glm::scale(glm::dmat4(1.0), glm::dvec3(half)));
    EXPECT_NEAR(shared::cuboidDistance(at, half), expected, 1e-6);
  }
}

/// The record's distance at a point in global voxels from the middle of the grid, evaluated in C++.
double recordDistance(const shared::CompositeObject& object, const glm::dvec3& voxels) {
  const glm::vec3 local = shared::localPoint(object, glm::vec3(voxels)), half(object.parameters);
  return (object.kind == shared::kKindCuboid ? shared::cuboidDistance(local, half) : shared::ellipsoidDistance(local, half)) *
         object.axisScale.w;
}

TEST(PrimitiveRecords, AreExactWhereTheShapeSurvivesAndLowerBoundsElsewhere) {
  std::mt19937 random(3);
  const GlobalGrid grid = globalGrid({glm::dvec3(-4.0), glm::dvec3(4.0)}, 64, 0);
  int sheared = 0;
  for (int i = 0; i < 300; ++i) {
    Primitive primitive = anyPrimitive(random);
    glm::dmat4 world = test::randomTransform(random, 2.0);
    const bool alongItsAxes = i % 3 == 0;  // scaled so, a cuboid stays one
    if (alongItsAxes) {
      primitive.shape = PrimitiveShape::cuboid;
      world = glm::rotate(glm::translate(glm::dmat4(1.0), anyPoint(random, 2.0)), 1.1, anyPoint(random, 1.0));
      world = glm::scale(world, {0.5, 2.0, -1.5}) * glm::inverse(glm::mat4_cast(primitive.rotation));
    }
    const shared::CompositeObject object = compositeObject(primitive, world, grid);
    ASSERT_EQ(object.present, 1u);
    const bool exact = std::abs(object.axisScale.w - 1.0f) < 1e-5f;
    EXPECT_TRUE(exact || (primitive.shape == PrimitiveShape::cuboid && !alongItsAxes));
    sheared += !exact;
    for (int k = 0; k < 10; ++k) {
      const glm::dvec3 at = anyPoint(random, 4.0);
      const glm::dmat4 unit = world * worldFromUnit(primitive);
      const double expected =
          (primitive.shape == PrimitiveShape::cuboid ? reference::cuboidDistance(at, unit) : reference::ellipsoidDistance(at, unit)) /
          grid.voxelSize;
      const double value = recordDistance(object, (at - centre(grid)) / grid.voxelSize);
      if (exact) {
        EXPECT_NEAR(value, expected, 3e-4) << "object " << i;  // of some 20 voxels: 1.5e-5
      } else {
        EXPECT_LE(std::abs(value), std::abs(expected) + 3e-4);
        EXPECT_GE(value * expected, -1e-3);
      }
    }
  }
  EXPECT_GT(sheared, 20) << "no longer reaches the case it is for";
}

TEST(PrimitiveRecords, DegenerateTransformsAreAbsentAndFlatOnesStayFinite) {
  const GlobalGrid grid = globalGrid({glm::dvec3(-1.0), glm::dvec3(1.0)}, 32, 0);
  for (const PrimitiveShape shape : {PrimitiveShape::cuboid, PrimitiveShape::ellipsoid}) {
    const Primitive p{shape, glm::dvec3(0.0), {1.0, 0.0, 0.0, 0.0}, glm::dvec3(0.5)};
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& scale : {glm::dvec3(0.0), glm::dvec3(1, 0, 1), glm::dvec3(nan, 1, 1), glm::dvec3(1, inf, 1), glm::dvec3(1e-300)})
      EXPECT_EQ(compositeObject(p, glm::scale(glm::dmat4(1.0), scale), grid).present, 0u);
    const shared::CompositeObject flat = compositeObject(p, glm::scale(glm::dmat4(1.0), {1.0, 1e-9, 1.0}), grid);
    ASSERT_EQ(flat.present, 1u);
    for (const double far : {0.0, 1e-6, 1.0, 40.0}) EXPECT_TRUE(std::isfinite(recordDistance(flat, {far, far, far})));
  }
}

class PrimitiveComposite : public test::DeviceTest {};

TEST_F(PrimitiveComposite, AgreesWithBruteForceInDouble) {
  if (!device.device) return;
  std::mt19937 random(4);
  std::vector<Asset> assets;
  for (int i = 0; i < 12; ++i) assets.emplace_back(anyPrimitive(random));
  Result<AssetStore> store = makeAssetStore(device, assets);
  ASSERT_TRUE(store.ok()) << message(store.error());
  const GlobalGrid grid = globalGrid({glm::dvec3(-3.0), glm::dvec3(3.0)}, 24, 0);
  std::vector<shared::CompositeObject> objects;
  std::vector<glm::dmat4> units;
  for (std::size_t i = 0; i < assets.size(); ++i) {
    const auto& primitive = std::get<Primitive>(assets[i]);
    glm::dmat4 world = test::randomTransform(random, 3.0);
    if (primitive.shape == PrimitiveShape::cuboid)
      world = glm::scale(glm::rotate(glm::translate(glm::dmat4(1.0), anyPoint(random, 3.0)), 0.5, glm::dvec3(1, 2, 3)), glm::dvec3(0.8));
    objects.push_back(compositeObject(store.value().entries[i], world, grid));
    units.push_back(world * worldFromUnit(primitive));
  }
  Result<CompositePass> pass = makeCompositePass(device, grid, store.value(), 12);
  ASSERT_TRUE(pass.ok()) << message(pass.error());
  EXPECT_TRUE(runCommands(device, [&](VkCommandBuffer commands) { recordComposite(commands, pass.value(), objects); }).ok());
  const std::vector<std::byte> bytes = readImage(device, pass.value().volume, kComputeWrite).value();
  double worst = 0.0;
  std::size_t n = 0;
  for (int k = 0; k < 24; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i, ++n) {
        if (n % 31 != 0) continue;  // brute force takes its time
        const glm::dvec3 at = grid.origin + grid.voxelSize * (glm::dvec3(i, j, k) + 0.5);
        double expected = 1e300;
        for (std::size_t o = 0; o < assets.size(); ++o) {
          const bool cuboid = std::get<Primitive>(assets[o]).shape == PrimitiveShape::cuboid;
          expected = std::min(expected, cuboid ? reference::cuboidDistance(at, units[o]) : reference::ellipsoidDistance(at, units[o]));
        }
        std::uint16_t half = 0;
        std::memcpy(&half, bytes.data() + 2 * n, 2);
        expected /= grid.voxelSize;
        // One unit in the last place of half floats, which some devices truncate to, and what single floats lose.
        worst = std::max(worst, std::abs(glm::unpackHalf1x16(half) - expected) / (std::abs(expected) * 0x1p-10 + 2e-4));
      }
  EXPECT_LT(worst, 1.0);
  destroyCompositePass(device, pass.value());
  destroyAssetStore(device, store.value());
}

}  // namespace
}  // namespace overcast
