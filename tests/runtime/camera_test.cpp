#include "formats/camera.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <glm/ext/matrix_transform.hpp>
#include "runtime/orbit.h"

namespace overcast {
namespace {

using glm::dmat4;
using glm::dvec3;
using glm::dvec4;

dvec3 project(const View& view, double aspect, const dvec3& world) {
  const dvec4 clip = clipFromRelative(view, aspect) * dvec4(world - eye(view), 1.0);
  return dvec3(clip) / clip.w;
}

TEST(Camera, LooksAtItsTargetWithUpUpwards) {
  const View view = lookAt({1, 2, 5}, {0, 1, 0}, {0, 1, 0}, 0.7);
  const dvec3 middle = project(view, 1.5, {0, 1, 0});
  EXPECT_NEAR(middle.x, 0.0, 1e-12);
  EXPECT_NEAR(middle.y, 0.0, 1e-12);
  EXPECT_LT(project(view, 1.5, {0, 1.5, 0}).y, 0.0) << "Vulkan's y runs down";
  EXPECT_NEAR(middle.z, view.nearPlane / std::sqrt(1.0 + 1.0 + 25.0), 1e-15);
  const View down = lookAt({0, 5, 0}, {0, 0, 0}, {0, 1, 0}, 0.7);  // up along the line of sight
  EXPECT_NEAR(project(down, 1.0, {0, 0, 0}).x, 0.0, 1e-12);
  EXPECT_NEAR(glm::determinant(glm::dmat3(down.worldFromView)), 1.0, 1e-12);
}

RC_GTEST_PROP(Camera, FramesAnyBoxTightly, ()) {
  const auto number = [](int low, int high) { return *rc::gen::inRange(low, high) * 0.01; };
  const dvec3 low(number(-5000, 5000), number(-5000, 5000), number(-5000, 5000));
  const Box box{low, low + dvec3(number(1, 1000), number(0, 1000), number(0, 1000))};
  const double aspect = number(40, 300);
  const View view = frameBox(box, {0, 1, 0}, aspect);
  double widest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 point((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y, (corner & 4) ? box.max.z : box.min.z);
    const dvec3 clip = project(view, aspect, point);
    RC_ASSERT(clip.z > 0.0 && clip.z < 1.0);
    widest = std::max({widest, std::abs(clip.x), std::abs(clip.y)});
  }
  RC_ASSERT(widest <= 1.0);
  RC_ASSERT(widest > 0.9);
}

TEST(Camera, OfTheSceneSitsWhereItsNodeIs) {
  Scene scene;
  scene.cameras.push_back({"main", 0.5, 0.02});
  scene.nodes.resize(2);
  scene.nodes[1].camera = 0;
  const dmat4 placed = glm::scale(glm::rotate(glm::translate(dmat4(1.0), {1, 2, 3}), 0.5, {0, 1, 0}), {2, 3, 4});
  const std::optional<View> view = sceneView(scene, {dmat4(1.0), placed});
  ASSERT_TRUE(view.has_value());
  EXPECT_EQ(view->verticalFieldOfView, 0.5);
  EXPECT_EQ(view->nearPlane, 0.02);
  EXPECT_LT(glm::length(eye(*view) - dvec3(1, 2, 3)), 1e-12);
  const dvec3 ahead = dvec3(1, 2, 3) + dvec3(-std::sin(0.5), 0, -std::cos(0.5));
  EXPECT_NEAR(project(*view, 1.0, ahead).x, 0.0, 1e-12);
  EXPECT_GT(project(*view, 1.0, ahead).z, 0.0);
  scene.nodes[1].camera = -1;
  EXPECT_FALSE(sceneView(scene, {dmat4(1.0), placed}).has_value());
}

RC_GTEST_PROP(Orbit, StartsAtTheViewItIsMadeFrom, ()) {
  const auto number = [] { return *rc::gen::inRange(-1000, 1000) * 0.01; };
  const dvec3 target(number(), number(), number());
  const dvec3 from = target + dvec3(number(), 0.3 * number(), number());
  RC_PRE(std::hypot(from.x - target.x, from.z - target.z) > 0.5);
  const View view = lookAt(from, target, {0, 1, 0}, 0.7);
  const Orbit orbit = orbitLike(view, target, 10.0);
  const View again = viewOf(orbit);
  for (int column = 0; column < 4; ++column) RC_ASSERT(glm::length(again.worldFromView[column] - view.worldFromView[column]) < 1e-9);
  RC_ASSERT(glm::length(orbit.target - target) < 1e-9);
}

TEST(Orbit, TurnsPansAndZooms) {
  const View view = lookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.7);
  Orbit orbit = orbitLike(view, {0, 0, 0}, 3.0);
  turn(orbit, {100.0, 0.0}, 200.0);  // half the height to the right: a quarter turn
  EXPECT_LT(glm::length(eye(viewOf(orbit)) - dvec3(-5, 0, 0)), 1e-9);
  turn(orbit, {0.0, 1e6}, 200.0);
  EXPECT_GT(eye(viewOf(orbit)).y, 4.99) << "straight down is as far as it goes";
  Orbit panned = orbitLike(view, {0, 0, 0}, 3.0);
  pan(panned, {0.0, 100.0}, 200.0);
  EXPECT_LT(glm::length(panned.target - dvec3(0, 5.0 * std::tan(0.35), 0)), 1e-9) << "what was in the middle is at the lower edge";
  zoom(panned, 1.0);
  EXPECT_LT(panned.distance, 5.0);
}

}  // namespace
}  // namespace overcast
