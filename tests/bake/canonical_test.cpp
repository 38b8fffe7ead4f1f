// Nothing that is baked or measured depends on how a mesh lists its vertices, triangles and corners.
#include "bake/canonical.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>

#include "bake/choose.h"
#include "bake/measure.h"
#include "bake/volume.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using Corners = std::array<std::array<double, 3>, 3>;

/// The corners of every triangle, from the smallest on.
std::vector<Corners> surfaceOf(const Mesh& mesh) {
  std::vector<Corners> surface;
  for (const glm::uvec3& t : mesh.triangles) {
    Corners corner{};
    for (int c = 0; c < 3; ++c)
      for (int axis = 0; axis < 3; ++axis) corner[static_cast<std::size_t>(c)][static_cast<std::size_t>(axis)] = mesh.positions[t[c]][axis];
    Corners smallest = corner;
    for (int turn = 0; turn < 2; ++turn) {
      std::rotate(corner.begin(), corner.begin() + 1, corner.end());
      smallest = std::min(smallest, corner);
    }
    surface.push_back(smallest);
  }
  std::sort(surface.begin(), surface.end());
  return surface;
}

/// Few places, both zeros among them, so that positions, corners and triangles repeat.
Mesh tangled() {
  Mesh mesh;
  const auto vertices = *rc::gen::inRange<std::uint32_t>(3, 40);
  for (std::uint32_t i = 0; i < vertices; ++i) {
    const auto coordinate = [] { return *rc::gen::elementOf(std::vector<double>{-1.5, -0.0, 0.0, 0.3, 1.0}); };
    mesh.positions.emplace_back(coordinate(), coordinate(), coordinate());
  }
  const auto corner = [&] { return *rc::gen::inRange<std::uint32_t>(0, vertices); };
  const auto triangles = *rc::gen::inRange(1, 60);
  for (int i = 0; i < triangles; ++i) mesh.triangles.emplace_back(corner(), corner(), corner());
  return mesh;
}

bool sameBits(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const glm::dvec3& p, const glm::dvec3& q) {
    return std::bit_cast<std::array<std::uint64_t, 3>>(p) == std::bit_cast<std::array<std::uint64_t, 3>>(q);
  });
}

RC_GTEST_PROP(Canonical, TheOrderOfTheInputIsGoneAndNothingElse, ()) {
  const Mesh mesh = tangled();
  std::uint64_t merged = 0, mergedAgain = 0;
  const Mesh first = canonicalOrder(mesh, merged);
  const Mesh second = canonicalOrder(reference::shuffled(mesh, *rc::gen::arbitrary<std::uint64_t>()), mergedAgain);
  RC_ASSERT(sameBits(first.positions, second.positions));
  RC_ASSERT(first.triangles == second.triangles);
  RC_ASSERT(merged == mergedAgain);
  RC_ASSERT(surfaceOf(first) == surfaceOf(mesh));
  const auto less = [](const glm::dvec3& a, const glm::dvec3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); };
  RC_ASSERT(std::adjacent_find(first.positions.begin(), first.positions.end(), [&](const auto& a, const auto& b) { return !less(a, b); }) ==
            first.positions.end());
}

RC_GTEST_PROP(Canonical, AnySoupBakesAndMeasuresTheSame, ()) {
  const int triangles = *rc::gen::inRange(1, 40);
  Mesh mesh = reference::triangleSoup(*rc::gen::arbitrary<std::uint64_t>(), triangles, 1.0);
  // Some triangles share corners, some are there twice: repair has choices to make.
  for (glm::uvec3& t : mesh.triangles) t.x = *rc::gen::inRange(0u, static_cast<unsigned>(mesh.positions.size()));
  mesh = reference::withDuplicates(mesh, 0.2, 1);
  const Mesh other = reference::shuffled(mesh, *rc::gen::arbitrary<std::uint64_t>());
  VolumeSettings settings;
  settings.resolution = 8;
  settings.errorSamples = 50;
  const auto first = bakeVolume(mesh, settings), second = bakeVolume(other, settings);
  RC_ASSERT(first.ok() == second.ok());
  if (!first.ok()) return;
  RC_ASSERT(first.value().volume.distance == second.value().volume.distance);
  RC_ASSERT(first.value().volume.origin == second.value().volume.origin);
  RC_ASSERT(first.value().error.rms == second.value().error.rms);
  RC_ASSERT(first.value().found.reorientedTriangles == second.value().found.reorientedTriangles);
  const MeasureSettings few{64, 1};
  const auto truth = drawProbes(mesh, few), again = drawProbes(other, few);
  RC_ASSERT(truth.points == again.points);
  RC_ASSERT(truth.exact == again.exact);
  RC_ASSERT(truth.winding == again.winding);
}

}  // namespace
}  // namespace overcast
