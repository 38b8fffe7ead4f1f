// worldFromLocal and the animations it applies, against closed forms.
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/scene.h"
#include "tests/formats/gltf_builder.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using test::GltfBuilder;
using testing::Contains;
using testing::HasSubstr;

constexpr double kQuarter = std::numbers::pi / 2.0;

/// A rotation about y as xyzw.
glm::dvec4 aboutY(double angle) {
  return {0.0, std::sin(angle / 2.0), 0.0, std::cos(angle / 2.0)};
}

/// One node and one channel that moves it.
Scene moving(AnimatedProperty property, Interpolation interpolation, std::vector<double> times, std::vector<glm::dvec4> values) {
  Scene scene;
  scene.nodes.emplace_back();
  scene.animations.push_back({"move", {{0, property, interpolation, std::move(times), std::move(values)}}});
  return scene;
}

glm::dvec3 at(const Scene& scene, double time, const glm::dvec3& point, bool loop = true) {
  return glm::dvec3(worldFromLocal(scene, time, loop).back() * glm::dvec4(point, 1.0));
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-12) << "component " << i;
}

TEST(Animation, StepHoldsAndLinearMixes) {
  const std::vector<glm::dvec4> values = {{0, 0, 0, 0}, {2, 4, 6, 0}, {2, 0, 0, 0}};
  const Scene step = moving(AnimatedProperty::translation, Interpolation::step, {0, 1, 2}, values);
  EXPECT_EQ(at(step, 0.999, {}), glm::dvec3(0));
  EXPECT_EQ(at(step, 1.0, {}), glm::dvec3(2, 4, 6));
  const Scene linear = moving(AnimatedProperty::translation, Interpolation::linear, {0, 1, 2}, values);
  EXPECT_EQ(at(linear, 0.25, {}), glm::dvec3(0.5, 1, 1.5));
  EXPECT_EQ(at(linear, 1.5, {}), glm::dvec3(2, 2, 3));
}

TEST(Animation, RotationsTurnAtConstantSpeedTheShortWay) {
  const Scene scene = moving(AnimatedProperty::rotation, Interpolation::linear, {0, 1}, {aboutY(0), aboutY(kQuarter)});
  for (const double t : {0.0, 0.125, 0.5, 0.75}) {
    expectNear(at(scene, t, {0, 0, 1}), {std::sin(t * kQuarter), 0, std::cos(t * kQuarter)});
  }
  const Scene flipped = moving(AnimatedProperty::rotation, Interpolation::linear, {0, 1}, {aboutY(0), -aboutY(kQuarter)});
  expectNear(at(flipped, 0.5, {0, 0, 1}), {std::sin(kQuarter / 2.0), 0, std::cos(kQuarter / 2.0)});
}

TEST(Animation, CubicSplinesReproduceCubics) {
  const auto p = [](double t) { return 1.0 - 2.0 * t + 0.5 * t * t - 0.25 * t * t * t; };
  const auto slope = [](double t) { return -2.0 + t - 0.75 * t * t; };
  std::vector<double> times = {0.0, 0.5, 3.0};
  std::vector<glm::dvec4> values;
  for (const double t : times) {
    for (const double x : {slope(t), p(t), slope(t)}) values.push_back({x, 0, 2 * x, 0});
  }
  const Scene scene = moving(AnimatedProperty::translation, Interpolation::cubicSpline, times, values);
  for (double t = 0.0; t < 3.0; t += 0.1) expectNear(at(scene, t, {}), {p(t), 0, 2 * p(t)});
}

TEST(Animation, CubicRotationsAreNormalised) {
  const glm::dvec4 still(0.0);
  const Scene scene =
      moving(AnimatedProperty::rotation, Interpolation::cubicSpline, {0, 1}, {still, aboutY(0), still, still, aboutY(kQuarter), still});
  for (const double t : {0.1, 0.3, 0.5, 0.9}) EXPECT_NEAR(glm::length(at(scene, t, {0, 0, 1})), 1.0, 1e-12);
  expectNear(at(scene, 0.5, {0, 0, 1}), {std::sin(kQuarter / 2.0), 0, std::cos(kQuarter / 2.0)});
}

TEST(Animation, LoopsOrClamps) {
  const Scene scene = moving(AnimatedProperty::translation, Interpolation::linear, {1, 3}, {{1, 0, 0, 0}, {3, 0, 0, 0}});
  EXPECT_EQ(animationDuration(scene), 3.0);
  EXPECT_EQ(at(scene, 0.0, {}).x, 1.0) << "before the first key";
  EXPECT_EQ(at(scene, 5.5, {}).x, 2.5) << "5.5 = 3 + 2.5";
  EXPECT_EQ(at(scene, -0.5, {}).x, 2.5) << "-0.5 = -3 + 2.5";
  EXPECT_EQ(at(scene, 5.5, {}, false).x, 3.0);
  EXPECT_EQ(at(scene, -0.5, {}, false).x, 1.0);
  EXPECT_EQ(animationDuration(Scene{}), 0.0);
}

TEST(Animation, AllAnimationsApplyTogether) {
  Scene scene = moving(AnimatedProperty::translation, Interpolation::step, {0}, {{5, 0, 0, 0}});
  scene.animations.push_back({"scale", {{0, AnimatedProperty::scale, Interpolation::step, {0}, {{2, 3, -4, 0}}}}});
  EXPECT_EQ(at(scene, 0.0, {1, 1, 1}), glm::dvec3(7, 3, -4));
}

TEST(Animation, ChildrenFollowTheirParentsInAnyOrder) {
  Scene scene = moving(AnimatedProperty::rotation, Interpolation::linear, {0, 1}, {aboutY(0), aboutY(kQuarter)});
  Node child;
  child.parent = 2;
  child.translation = {0, 0, 1};
  Node root;
  root.children = {1};
  root.scale = {2, 2, 2};
  scene.nodes = {Node{}, child, root};
  scene.animations[0].channels[0].node = 2;
  const auto world = worldFromLocal(scene, 0.5);
  expectNear(glm::dvec3(world[1][3]), {2 * std::sin(kQuarter / 2), 0, 2 * std::cos(kQuarter / 2)});
  expectNear(glm::dvec3(world[0][3]), {0, 0, 0});
}

TEST(Animation, BoundsCoverTheWholeMovement) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {100, 100, 100}};  // the last is used by no triangle
  mesh.triangles = {{0, 1, 2}};
  Scene scene = sceneFromMesh(mesh);
  const Box still = worldBounds(scene);
  EXPECT_EQ(still.min, glm::dvec3(0));
  EXPECT_EQ(still.max, glm::dvec3(1, 0, 1));
  scene.animations.push_back({"", {{0, AnimatedProperty::translation, Interpolation::linear, {0, 2}, {{0, 0, 0, 0}, {10, -5, 0, 0}}}}});
  const Box moved = worldBounds(scene);
  EXPECT_EQ(moved.min, glm::dvec3(0, -5, 0));
  EXPECT_EQ(moved.max, glm::dvec3(11, 0, 1));
  EXPECT_TRUE(isEmpty(worldBounds(Scene{})));
}

/// A triangle whose node an animation moves with these keys.
GltfBuilder animated(const std::vector<float>& times, int output, GltfBuilder builder, const char* path) {
  const int input = builder.floats(times, 1);
  builder.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}},
                                 {"samplers", {{{"input", input}, {"output", output}}}}}};
  return builder;
}

Result<Scene> read(const GltfBuilder& builder) {
  const test::TemporaryFolder folder;
  return readScene(builder.gltf(folder.path));
}

TEST(Animation, IsReadFromGltf) {
  GltfBuilder builder = GltfBuilder::triangle();
  const int output = builder.floats({0, 0, 0, 4, 0, 0}, 3);
  auto scene = read(animated({0, 2}, output, builder, "translation"));
  ASSERT_TRUE(scene) << message(scene.error());
  ASSERT_EQ(scene.value().animations.size(), 1u);
  EXPECT_EQ(at(scene.value(), 0.5, {}), glm::dvec3(1, 0, 0));
}

TEST(Animation, RotationsMayBeNormalisedIntegers) {
  GltfBuilder builder = GltfBuilder::triangle();
  const int view = builder.view(std::vector<std::int16_t>{0, 0, 0, 32767, 0, 23170, 0, 23170});
  const int output =
      builder.accessor({{"bufferView", view}, {"componentType", 5122}, {"normalized", true}, {"count", 2}, {"type", "VEC4"}});
  auto scene = read(animated({0, 1}, output, builder, "rotation"));
  ASSERT_TRUE(scene) << message(scene.error());
  const glm::dvec3 turned = at(scene.value(), 1.0, {0, 0, 1}, false);
  EXPECT_NEAR(turned.x, 1.0, 1e-4);
  EXPECT_NEAR(glm::length(turned), 1.0, 1e-5);
}

TEST(Animation, BrokenChannelsAreLeftOutWithANote) {
  GltfBuilder builder = GltfBuilder::triangle();
  const int output = builder.floats({0, 0, 0, 4, 0, 0}, 3);
  for (const auto& times : {std::vector<float>{1, 1}, {2, 1}, {-1, 1}, {0, std::nanf("")}}) {
    auto scene = read(animated(times, output, builder, "translation"));
    ASSERT_TRUE(scene) << message(scene.error());
    EXPECT_TRUE(scene.value().animations.empty());
    EXPECT_THAT(scene.value().notes, Contains(HasSubstr("1 animation channels have times")));
  }
  auto weights = read(animated({0, 1}, output, builder, "weights"));
  ASSERT_TRUE(weights);
  EXPECT_THAT(weights.value().notes, Contains(HasSubstr("target something else")));
  builder.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1};
  auto matrix = read(animated({0, 1}, output, builder, "translation"));
  ASSERT_TRUE(matrix);
  EXPECT_THAT(matrix.value().notes, Contains(HasSubstr("a node that has a matrix")));
  EXPECT_EQ(at(matrix.value(), 1.0, {}), glm::dvec3(5, 0, 0));
}

TEST(Animation, ImpossibleChannelsAreErrors) {
  GltfBuilder builder = GltfBuilder::triangle();
  const int output = builder.floats({0, 0, 0, 4, 0, 0}, 3);
  auto count = read(animated({0, 1, 2}, output, builder, "translation"));
  ASSERT_FALSE(count);
  EXPECT_THAT(message(count.error()), HasSubstr("animations/0/channels/0: output: has 2 elements for 3 keys"));
  GltfBuilder sampler = animated({0, 1}, output, builder, "translation");
  sampler.json["animations"][0]["samplers"][0]["interpolation"] = "BOUNCE";
  auto interpolation = read(sampler);
  ASSERT_FALSE(interpolation);
  EXPECT_THAT(message(interpolation.error()), HasSubstr("interpolation 'BOUNCE'"));
}

}  // namespace
}  // namespace overcast
