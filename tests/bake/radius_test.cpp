// Kernels and radius fields: the linear programme against brute force, baked fields against closed forms and rays cast by brute force.
#include "bake/radius.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "bake/kernel.h"
#include "tests/bake/test_meshes.h"
#include "tests/reference/distance.h"
#include "tests/reference/radius.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using test::boxBetween;

RadiusField baked(const Mesh& mesh, int side) {
  const Result<RadiusField> field = bakeRadius(mesh, {side});
  EXPECT_TRUE(field) << (field ? "" : message(field.error()));
  return field ? field.value() : RadiusField{};
}

Mesh turned(Mesh mesh, const glm::dquat& rotation, const glm::dvec3& offset, double factor) {
  for (glm::dvec3& p : mesh.positions) p = factor * (rotation * p) + offset;
  return mesh;
}

TEST(Kernel, AgreesWithEveryFourPlanesOfRandomPolyhedra) {
  std::mt19937 random(1);
  int stars = 0;
  for (int trial = 0; trial < 40; ++trial) {
    Mesh mesh = reference::icosphere(1.0, 0);
    const double roughness = 0.04 * trial;
    for (glm::dvec3& p : mesh.positions)
      for (int axis = 0; axis < 3; ++axis) p[axis] += roughness * (static_cast<double>(random()) / 2147483648.0 - 1.0);
    const double exact = reference::largestMargin(mesh);
    const Kernel kernel = findKernel(mesh);
    EXPECT_NEAR(kernel.margin, exact, 1e-9) << "trial " << trial;
    EXPECT_NEAR(starMargin(mesh, kernel.centre), kernel.margin, 1e-12);
    stars += exact > 0.0 ? 1 : 0;
  }
  EXPECT_GT(stars, 5);
  EXPECT_LT(stars, 40) << "no polyhedron without a kernel was tried";
}

TEST(Kernel, IsTheInscribedBallOfConvexShapes) {
  const Kernel cube = findKernel(boxBetween({1.0, 2.0, 3.0}, {2.0, 4.0, 6.0}));
  EXPECT_NEAR(cube.margin, 0.5, 1e-12);
  EXPECT_NEAR(cube.centre.x, 1.5, 1e-12);
  const Mesh sphere = reference::icosphere(2.0, 4);
  EXPECT_NEAR(findKernel(sphere).margin, 2.0, reference::icosphereSag(2.0, 4));
  EXPECT_LT(glm::length(findKernel(sphere).centre), reference::icosphereSag(2.0, 4));
}

TEST(Kernel, FollowsRotationPlaceScaleAndTheOrderOfFaces) {
  const Mesh mesh = reference::withRadius(reference::icosphere(1.0, 3), reference::bumpyRadius());
  const Kernel kernel = findKernel(mesh);
  ASSERT_GT(kernel.margin, 0.0);
  const glm::dquat rotation = glm::normalize(glm::dquat(0.3, -0.5, 0.7, 0.2));
  for (const double factor : {1e-4, 1.0, 1e4}) {
    const glm::dvec3 offset = glm::dvec3(100.0, -50.0, 20.0) * factor;
    Mesh moved = turned(mesh, rotation, offset, factor);
    std::shuffle(moved.triangles.begin(), moved.triangles.end(), std::mt19937(4));
    const Kernel other = findKernel(moved);
    EXPECT_NEAR(other.margin, factor * kernel.margin, 1e-9 * factor);
    EXPECT_LT(glm::length(other.centre - (factor * (rotation * kernel.centre) + offset)), 1e-8 * factor);
  }
}

TEST(Kernel, KnowsShapesThatHaveNone) {
  EXPECT_LT(findKernel(reference::torusMesh(1.0, 0.3, 32, 16)).margin, 0.0);
  const Mesh apart = reference::joined(boxBetween(glm::dvec3(0.0), glm::dvec3(1.0)), boxBetween(glm::dvec3(2.0), glm::dvec3(3.0)));
  EXPECT_LT(findKernel(apart).margin, 0.0);
  EXPECT_LT(findKernel(reference::insideOut(reference::icosphere(1.0, 1))).margin, 0.0);
}

TEST(Kernel, TakesLittleTimeForManyFaces) {
  const Mesh mesh = reference::withRadius(reference::icosphere(1.0, 6), reference::bumpyRadius());  // 81,920 faces
  const Kernel kernel = findKernel(mesh);
  EXPECT_GT(kernel.margin, 0.0);
  EXPECT_LT(kernel.steps, 100) << "each step looks at all faces once";
}

TEST(StarCentre, OfANearlyStarShapedMeshSeesMostOfIt) {
  // A small mushroom at either pole: each can be seen below its rim from near its own pole alone.
  Mesh mesh = reference::icosphere(1.0, 5);
  for (glm::dvec3& p : mesh.positions)
    if (std::abs(p.z) > 0.99) p = {1.6 * p.x, 1.6 * p.y, 1.15 * p.z};
  const StarCentre centre = starCentre(mesh);
  EXPECT_LT(centre.margin, 0.0);
  EXPECT_GT(centre.visible, 0.95);
  EXPECT_LT(centre.visible, 1.0);
  const Result<RadiusField> field = bakeRadius(mesh, {32});
  EXPECT_TRUE(field) << message(field.error());
}

TEST(BakeRadius, SphereIsASphereWhereverItIs) {
  const double sag = reference::icosphereSag(1.0, 5);
  for (const double scale : {1e-4, 1.0, 1e4}) {
    const glm::dvec3 where = glm::dvec3(1e3, -2e3, 500.0) * scale;
    const Mesh mesh = reference::moved(reference::scaled(reference::icosphere(1.0, 5), scale), where);
    const RadiusField field = baked(mesh, 16);
    EXPECT_LT(glm::length(field.centre - where), sag * scale);
    for (const RadiusTexel& t : field.levels[0].texel) {
      EXPECT_NEAR(t.mean, scale, 2.0 * sag * scale);
      EXPECT_LT(t.variance, sag * sag * scale * scale);
      EXPECT_LT(glm::length(t.slope), 0.14f * t.mean);
    }
  }
}

TEST(BakeRadius, TexelsAreMeansOfRaysCastByBruteForce) {
  const Mesh mesh = reference::withRadius(reference::icosphere(1.0, 2), reference::bumpyRadius());
  const int side = 8, fine = (side - 1) * kRadiusRays;
  const RadiusField field = baked(mesh, side);
  const double range = field.levels[0].largest - field.levels[0].smallest;
  for (unsigned face = 0; face < 6; ++face)
    for (int j = 1; j + 1 < side; j += 2)
      for (int i = 1; i + 1 < side; i += 3) {
        double weights = 0.0, first = 0.0, second = 0.0;
        for (int v = -kRadiusRays / 2; v <= kRadiusRays / 2; ++v)
          for (int u = -kRadiusRays / 2; u <= kRadiusRays / 2; ++u) {
            const glm::dvec3 d = texelDirection(fine + 1, face, i * kRadiusRays + u, j * kRadiusRays + v);
            const bool outer = std::abs(u) == kRadiusRays / 2, lower = std::abs(v) == kRadiusRays / 2;
            const double weight = (outer ? 0.5 : 1.0) * (lower ? 0.5 : 1.0) / std::pow(glm::length(d), 3.0);
            const double r = reference::outermostCrossing(mesh, field.centre, glm::normalize(d));
            weights += weight;
            first += weight * r;
            second += weight * r * r;
          }
        const RadiusTexel& texel = field.levels[0].texel[texelIndex(side, face, i, j)];
        const double mean = first / weights, variance = second / weights - mean * mean;
        EXPECT_NEAR(texel.mean, mean, range * 0x1p-12 + 1e-6);
        EXPECT_NEAR(texel.variance, variance, variance * 0x1p-10 + 1e-7);
      }
}

TEST(BakeRadius, ClosedFormsComeOutAsSurfaces) {
  const struct {
    Mesh mesh;
    reference::RadiusFunction radius;
    double tolerance;  // half a texel's curvature, at edges its slope
  } cases[] = {{reference::withRadius(reference::icosphere(1.0, 5), reference::ellipsoidRadius({1.0, 0.6, 0.8})),
                reference::ellipsoidRadius({1.0, 0.6, 0.8}), 2e-3},
               {reference::boxMesh({1.0, 0.7, 0.9}), reference::cuboidRadius({1.0, 0.7, 0.9}), 2e-2}};
  for (const auto& shape : cases) {
    const RadiusField field = baked(shape.mesh, 64);
    // A mirror-symmetric body may have more than one best centre: the radius is compared about the one found.
    double worst = 0.0;
    for (const glm::dvec3& p : reference::randomPoints({glm::dvec3(-1.0), glm::dvec3(1.0)}, 400, 6)) {
      const glm::dvec3 surface = shape.radius(glm::normalize(p)) * glm::normalize(p);
      worst = std::max(worst, std::abs(sampleRadius(field, surface)));
    }
    EXPECT_LT(worst, shape.tolerance);
  }
}

TEST(BakeRadius, LevelsKeepTheMeanOverAllDirections) {
  const RadiusField field = baked(reference::withRadius(reference::icosphere(1.0, 4), reference::bumpyRadius()), 64);
  double expected = 0.0;
  for (const RadiusLevel& level : field.levels) {
    double weights = 0.0, sum = 0.0, squares = 0.0;
    for (unsigned face = 0; face < 6; ++face)
      for (int j = 0; j < level.side; ++j)
        for (int i = 0; i < level.side; ++i) {
          const glm::dvec3 d = texelDirection(level.side, face, i, j);
          const auto end = [&](int k) { return k == 0 || k == level.side - 1 ? 0.5 : 1.0; };
          const double weight = end(i) * end(j) / std::pow(glm::length(d), 3.0);
          const RadiusTexel& t = level.texel[texelIndex(level.side, face, i, j)];
          weights += weight;
          sum += weight * t.mean;
          squares += weight * (t.variance + double{t.mean} * t.mean);
        }
    if (expected == 0.0) expected = sum / weights;
    // Two and four texels a face are too few for this sum to be the integral.
    EXPECT_NEAR(sum / weights, expected, (level.side >= 8 ? 2e-3 : 3e-2) * expected) << level.side;
    if (level.side >= 8) {
      EXPECT_NEAR(std::sqrt(squares / weights), expected * 1.02, 0.02 * expected) << level.side;
    }
  }
}

TEST(BakeRadius, SharedTexelsAreTheSameOnAllFacesAtAllLevels) {
  const RadiusField field = baked(reference::withRadius(reference::icosphere(1.0, 4), reference::bumpyRadius()), 32);
  for (const RadiusLevel& level : field.levels)
    for (unsigned face = 0; face < 6; ++face)
      for (int j = 0; j < level.side; ++j)
        for (int i = 0; i < level.side; ++i) {
          const RadiusTexel& own = level.texel[texelIndex(level.side, face, i, j)];
          const RadiusTexel& twin = level.texel[texelTowards(level.side, texelDirection(level.side, face, i, j))];
          ASSERT_EQ(own.mean, twin.mean);
          ASSERT_EQ(own.variance, twin.variance);
          ASSERT_EQ(own.slope, twin.slope);
        }
}

TEST(BakeRadius, AnAsteroidIsWithinOnePercentOfItsDiagonalNearItsSurface) {
  const Mesh mesh = reference::withRadius(reference::icosphere(1.0, 4), reference::bumpyRadius());
  const RadiusField field = baked(mesh, 32);
  const double size = diagonal(bounds(mesh));
  double squares = 0.0;
  int near = 0;
  const std::vector<glm::dvec3> points = reference::randomPoints(bounds(field), 1500, 12);
  const std::vector<double> distances = reference::distance(mesh, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 p = points[i];
    const double exact = distances[i];
    if (exact > 0.05 * size) continue;
    const bool inside = glm::length(p - field.centre) < reference::outermostCrossing(mesh, field.centre, glm::normalize(p - field.centre));
    const double error = sampleRadius(field, p) - (inside ? -exact : exact);
    squares += error * error;
    ++near;
  }
  ASSERT_GT(near, 100);
  EXPECT_LT(std::sqrt(squares / near), 0.01 * size);
}

TEST(BakeRadius, GivesTheSameBytesForAnyThreadCount) {
  const Mesh mesh = reference::withRadius(reference::icosphere(1.0, 4), reference::bumpyRadius());
  RadiusField first;
  for (const int threads : {1, 2, 4}) {
    tbb::task_arena arena(threads);
    const RadiusField field = arena.execute([&] { return baked(mesh, 16); });
    if (first.levels.empty()) first = field;
    EXPECT_EQ(field.centre, first.centre);
    for (std::size_t l = 0; l < field.levels.size(); ++l)
      for (std::size_t i = 0; i < field.levels[l].texel.size(); ++i) {
        ASSERT_EQ(field.levels[l].texel[i].mean, first.levels[l].texel[i].mean);
        ASSERT_EQ(field.levels[l].texel[i].variance, first.levels[l].texel[i].variance);
      }
  }
}

TEST(BakeRadius, AMeshInsideOutIsBakedAsTheSolidItShows) {
  const Mesh mesh = reference::icosphere(1.0, 3);
  const RadiusField field = baked(reference::insideOut(mesh), 8);
  EXPECT_NEAR(sampleRadius(field, field.centre), -1.0, 0.02);
}

TEST(BakeRadius, SaysWhyAMeshCannotBeRepresented) {
  const auto refused = [](const Mesh& mesh, int side, const char* part) {
    const Result<RadiusField> field = bakeRadius(mesh, {side});
    ASSERT_FALSE(field) << part;
    EXPECT_NE(message(field.error()).find(part), std::string::npos) << message(field.error());
  };
  const Mesh sphere = reference::icosphere(1.0, 2);
  Mesh open = sphere;
  open.triangles.resize(open.triangles.size() / 2);
  refused(open, 16, "leaves through a hole");
  refused(reference::torusMesh(1.0, 0.3, 32, 16), 16, "hole");
  refused(sphere, 12, "power of two");
  refused(sphere, 256, "power of two");
  refused(Mesh{}, 16, "no triangle");
  refused(reference::scaled(sphere, 1e-20), 16, "units");
  Mesh point = sphere;
  for (glm::dvec3& p : point.positions) p = glm::dvec3(1.0);
  refused(point, 16, "units");
  const Result<RadiusField> stopped = bakeRadius(sphere, {16}, [](double) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_NE(message(stopped.error()).find("interrupted"), std::string::npos);
}

}  // namespace
}  // namespace overcast
