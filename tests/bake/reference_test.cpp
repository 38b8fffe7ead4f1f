#include "bake/reference.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/bake/reference_scenes.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

TraceSettings quick() {
  TraceSettings settings;
  settings.samples = 128;
  return settings;
}

float valueAt(const Reference& reference, int x, int y, const std::string& channel) {
  return at(reference.image, x, y, channelIndex(reference.image, channel));
}

/// A ball of radius 1 far from the origin, a floor below it.
Scene ballOnFloor() {
  Scene scene;
  Mesh ball = reference::icosphere(1.0, 4);
  for (const glm::dvec3& position : ball.positions) ball.normals.emplace_back(glm::normalize(position));
  test::addMesh(scene, test::flatFloor(4.0), glm::vec3(0.5f)).translation = {1e5, 0, 0};
  test::addMesh(scene, ball, {0.9f, 0.1f, 0.1f}).translation = {1e5, 1, 0};
  return scene;
}

TEST(Reference, PixelsAreWhatACameraSees) {
  const TracedScene scene = test::traced(ballOnFloor());
  const glm::dvec3 from(1e5 + 1.0, 2.5, 6.0), centre(1e5, 1, 0);
  const ReferenceView view{lookAt(from, centre, {0, 1, 0}, 0.7), 48, 32};
  const Reference reference = traceView(scene, view, quick()).value();
  ASSERT_EQ(reference.image.width, 48);
  const glm::dmat4 clip = clipFromRelative(view.view, 1.5);
  int balls = 0, floors = 0, nothing = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 48; ++x) {
      // The runtime's way through the same pixel.
      const glm::dvec4 far = glm::inverse(clip) * glm::dvec4((2 * x + 1.0) / 48 - 1, (2 * y + 1.0) / 32 - 1, 0.5, 1);
      const glm::dvec3 direction = glm::normalize(glm::dvec3(far) / far.w);
      const double along = glm::dot(centre - from, direction), past = glm::length(from + along * direction - centre);
      const double down = -from.y / direction.y;
      const glm::dvec3 ground = from + down * direction - glm::dvec3(1e5, 0, 0);
      const float depth = valueAt(reference, x, y, "depth"), object = valueAt(reference, x, y, "object");
      if (std::abs(past - 1.0) < 0.01) continue;  // the silhouette, which the mesh cuts short
      if (past < 1.0) {
        const double distance = along - std::sqrt(1.0 - past * past);
        EXPECT_NEAR(depth, distance, 0.01);
        const glm::dvec3 normal = from + distance * direction - centre;
        for (int axis = 0; axis < 3; ++axis)
          EXPECT_NEAR(valueAt(reference, x, y, std::string("normal.") + "XYZ"[axis]), normal[axis], 0.03);
        EXPECT_EQ(object, 1.0f);
        ++balls;
      } else if (down > 0.0 && std::max(std::abs(ground.x), std::abs(ground.z)) < 4.0) {
        EXPECT_NEAR(depth, down, 1e-5 * down);
        EXPECT_EQ(valueAt(reference, x, y, "normal.Y"), 1.0f);
        EXPECT_EQ(object, 0.0f);
        ++floors;
      } else if (down <= 0.0 || std::max(std::abs(ground.x), std::abs(ground.z)) > 4.0) {
        EXPECT_EQ(depth, -1.0f);
        EXPECT_EQ(object, -1.0f);
        EXPECT_EQ(valueAt(reference, x, y, "sky"), 0.0f);
        ++nothing;
      }
    }
  EXPECT_GT(balls, 100);
  EXPECT_GT(floors, 100);
  EXPECT_GT(nothing, 100);
}

TEST(Reference, WhatIsNearerThanTheNearPlaneIsNotSeen) {
  const TracedScene scene = test::traced(ballOnFloor());
  ReferenceView view{lookAt({1e5, 5, 0}, {1e5, 0, 0}, {0, 0, 1}, 0.5), 5, 5};
  EXPECT_EQ(valueAt(traceView(scene, view, quick()).value(), 2, 2, "object"), 1.0f);
  view.view.nearPlane = 4.5;
  const Reference reference = traceView(scene, view, quick()).value();
  EXPECT_EQ(valueAt(reference, 2, 2, "object"), 0.0f);
  EXPECT_NEAR(valueAt(reference, 2, 2, "depth"), 5.0f, 1e-3f);
}

TEST(Reference, InfoSaysWhatTheChannelsHold) {
  const TracedScene scene = test::traced(ballOnFloor());
  TraceSettings settings = quick();
  settings.distanceBound = 0.5;
  const Reference reference = tracePoints(scene, 700, settings).value();
  EXPECT_EQ(reference.info.points, 700u);
  EXPECT_EQ(reference.info.distanceBound, 0.5);
  for (const ReferenceQuantity& quantity : reference.info.quantities) {
    EXPECT_EQ(quantity.samples, 128u);
    double sum = 0.0, errors = 0.0;
    const int channels = quantity.name == "colour" || quantity.name == "light" || quantity.name == "bounce" ? 3 : 1;
    for (int i = 0; i < 700; ++i) {
      const int first = channelIndex(reference.image, quantity.name == "colour" ? "R"
                                                      : channels == 3           ? quantity.name + ".R"
                                                                                : quantity.name);
      for (int c = 0; c < channels; ++c) sum += static_cast<double>(at(reference.image, i, 0, first + c)) / channels;
      errors += static_cast<double>(valueAt(reference, i, 0, quantity.name + ".error"));
    }
    EXPECT_NEAR(quantity.mean, sum / 700, 1e-6) << quantity.name;
    EXPECT_NEAR(quantity.meanError, errors / 700, 1e-6) << quantity.name;
    EXPECT_GE(quantity.largestError, quantity.meanError);
  }
  EXPECT_GT(quantityNamed(reference.info, "ao")->mean, quantityNamed(reference.info, "sky")->mean);
}

TEST(Reference, PointsAreEvenAndOutsideOfSolids) {
  // Half of the ball is below the slab's top.
  Scene scene;
  test::addMesh(scene, reference::icosphere(1.0, 4), glm::vec3(0.5f));
  test::addMesh(scene, reference::moved(reference::boxMesh({2.0, 1.0, 2.0}), {0.0, -1.0, 0.0}), glm::vec3(0.5f));
  const TracedScene traced = test::traced(scene);
  const Reference reference = tracePoints(traced, 2000, quick()).value();
  ASSERT_EQ(reference.info.points, 2000u);
  double ball = 0.0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const int x = static_cast<int>(i % 1024), y = static_cast<int>(i / 1024);
    glm::dvec3 p, normal;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = static_cast<double>(valueAt(reference, x, y, std::string("position.") + "XYZ"[axis])) + reference.info.origin[axis];
      normal[axis] = static_cast<double>(valueAt(reference, x, y, std::string("normal.") + "XYZ"[axis]));
    }
    EXPECT_EQ(valueAt(reference, x, y, "depth"), 0.0f);
    if (valueAt(reference, x, y, "object") == 0.0f) {
      EXPECT_GT(p.y, -0.1) << "within the slab";
      EXPECT_GT(glm::dot(p, normal), 0.9) << "outwards";
      ball += 1.0;
    } else {
      EXPECT_FALSE(std::abs(p.y) < 1e-6 && std::hypot(p.x, p.z) < 0.8) << "within the ball";
    }
  }
  EXPECT_EQ(valueAt(reference, 1023, 1, "depth"), -1.0f) << "the rest of the last row";
  const double pi = 3.14159265358979, ballArea = 2.0 * pi, slabArea = 16.0 - pi + 16.0 + 4.0 * 8.0,
               share = ballArea / (ballArea + slabArea);
  EXPECT_NEAR(ball / 2000.0, share, 4.0 * std::sqrt(share * (1.0 - share) / 2000.0));
}

TEST(Reference, ScenesWithoutASurfaceAreErrors) {
  EXPECT_FALSE(makeTracedScene(Scene{}, 0.0).ok());
  Scene flat = ballOnFloor();
  for (Node& node : flat.nodes) node.scale = glm::dvec3(0.0);
  flat.nodes[1].translation = flat.nodes[0].translation;
  EXPECT_FALSE(makeTracedScene(flat, 0.0).ok());
}

TEST(Reference, AnimationsMoveWhatIsTraced) {
  Scene scene = ballOnFloor();
  scene.animations.emplace_back().channels.push_back(
      {1, AnimatedProperty::translation, Interpolation::linear, {0.0, 1.0}, {{1e5, 1, 0, 0}, {1e5 + 2.0, 1, 0, 0}}});
  const ReferenceView view{lookAt({1e5 + 1.0, 5, 0}, {1e5 + 1.0, 0, 0}, {0, 0, 1}, 0.5), 5, 5};
  EXPECT_EQ(valueAt(traceView(test::traced(scene, 0.5), view, quick()).value(), 2, 2, "object"), 1.0f);
}

}  // namespace
}  // namespace overcast
