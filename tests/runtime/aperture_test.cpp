// The aperture pass: what pixels receive against counted directions, on the device and through a whole frame; and that it costs nothing
// where there are no apertures.
#include "runtime/passes/aperture/aperture_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

#include "formats/aperture.h"
#include "tests/reference/caps.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/frames.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;

constexpr std::array kModes{ApertureMode::exact, ApertureMode::smoothstep, ApertureMode::fast, ApertureMode::accurate};
constexpr double kPi = std::numbers::pi;

glm::vec3 tilted(double angle, double azimuth) {
  return {std::sin(angle) * std::cos(azimuth), std::cos(angle), std::sin(angle) * std::sin(azimuth)};
}

/// A square of side 4 in the plane y = 0, every vertex with the same aperture.
Mesh square(const Aperture& aperture, float ambient) {
  Mesh mesh;
  mesh.name = "square";
  mesh.positions = {{-2, 0, -2}, {-2, 0, 2}, {2, 0, 2}, {2, 0, -2}};
  mesh.normals.assign(4, {0, 1, 0});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.parts = {{0, 2, 0}};
  mesh.visibility = VertexVisibility{ApertureBits::packed64, std::vector<Aperture>(4, aperture), std::vector<float>(4, ambient), {}};
  return mesh;
}

/// The floor of bakedScene alone, seen as `mesh`.
Scene floorScene(const fs::path& folder, Mesh mesh) {
  Scene scene = bakedScene(folder, {});
  scene.meshes = {std::move(mesh)};
  scene.nodes.resize(1);
  scene.nodes[0].translation = {0.0, 0.0, 0.0};
  scene.lighting->areaLights = {{{0.7f, 1.5f, -0.4f}, 0.5f, {3.0f, 2.0f, 1.0f}}, {{-2.5f, 0.2f, 0.3f}, 0.6f, {0.5f, 1.0f, 4.0f}}};
  scene.lighting->sun = Sun{glm::normalize(glm::vec3(-0.3f, 1.0f, 0.6f)), {1.5f, 1.4f, 1.2f}, 0.05f};
  return scene;
}

View fromAbove() {
  return lookAt({0.3, 5.0, 1.0}, {0.0, 0.0, 0.0}, {0, 1, 0}, 0.7);
}

TEST(ApertureLights, AreTheSunsLightAndSpheresSeenFromTheEye) {
  Lighting lighting;
  EXPECT_TRUE(apertureLights(lighting, {}, {0, 0, 0}).empty());
  lighting.sun = Sun{{0.0f, 2.0f, 0.0f}, {3.0f, 2.0f, 1.0f}, 0.00465f};
  lighting.areaLights = {{{1e6f, 2.0f, 3.0f}, 0.5f, {1, 1, 1}}, {{0, 0, 0}, 0.5f, {0, 0, 0}}, {{0, 0, 0}, 0.0f, {1, 1, 1}}};
  const std::vector<shared::ApertureLight> lights = apertureLights(lighting, {}, {1e6, 0.0, 1.0});
  ASSERT_EQ(lights.size(), 2u) << "those without colour or size are left out";
  EXPECT_EQ(lights[0].place, glm::vec4(0.0f, 1.0f, 0.0f, 0.00465f));
  EXPECT_NEAR(lights[0].radiance.x * static_cast<float>(reference::capArea(0.00465L)), 3.0f, 1e-5f);
  EXPECT_EQ(lights[1].place, glm::vec4(0.0f, 2.0f, 2.0f, 0.5f));
  lighting.sun->angularRadius = 0.0f;
  EXPECT_TRUE(std::isfinite(apertureLights(lighting, {}, {0, 0, 0})[0].radiance.x)) << "a sun without size still shines";
}

TEST(ApertureLights, MoveWithTheirNodes) {
  Lighting lighting;
  lighting.areaLights = {{{1, 0, 0}, 0.5f, {1, 1, 1}, 1}, {{1, 0, 0}, 0.5f, {1, 1, 1}, -1}};
  glm::dmat4 moved(2.0);  // twice as large: the light's radius stays
  moved[3] = {10.0, 20.0, 30.0, 1.0};
  const std::array<glm::dmat4, 2> nodes{glm::dmat4(1.0), moved};
  const std::vector<shared::ApertureLight> lights = apertureLights(lighting, nodes, {1.0, 0.0, 0.0});
  EXPECT_EQ(lights[0].place, glm::vec4(11, 20, 30, 0.5f));
  EXPECT_EQ(lights[1].place, glm::vec4(0, 0, 0, 0.5f));
}

TEST(ApertureFormulas, SpheresAreCaps) {
  const shared::ApertureLight light{{0, 3, 0, 1.0f}, {1, 1, 1, 0}};
  const glm::vec3 normal(0, 0, 1);
  EXPECT_NEAR(shared::lightCap(light, {0, 1, 0}, normal).w, std::asin(0.5f), 1e-6f);
  EXPECT_NEAR(shared::lightCap(light, {0, 1, 0}, normal).y, 1.0f, 1e-6f);
  EXPECT_NEAR(shared::lightCap(light, {0, -9996, 0}, normal).w, 1.0f / 9999.0f, 1e-10f) << "far lights keep their size";
  EXPECT_EQ(shared::lightCap(light, {0, 2.5f, 0}, normal).w, shared::kCapRightAngle) << "from within";
  EXPECT_EQ(glm::vec3(shared::lightCap(light, {0, 3, 0}, normal)), normal) << "from the centre";
}

TEST(ApertureFormulas, PackingAgreesWithTheFormats) {
  std::mt19937 random(3);
  const auto uniform = [&](double low, double high) { return low + (high - low) * (static_cast<double>(random()) / 4294967296.0); };
  double worst = 0.0;
  for (int i = 0; i < 4000; ++i) {
    glm::vec3 axis(tilted(uniform(0.0, kPi), uniform(-kPi, kPi)));
    if (i < 6) axis = glm::vec3(i / 2 == 0, i / 2 == 1, i / 2 == 2) * (i % 2 ? -1.0f : 1.0f);
    const float radius = static_cast<float>(uniform(0.0, 0.5 * kPi)), ambient = static_cast<float>(uniform(0.0, 1.0));
    const glm::uvec2 code = shared::aperturePacked({axis, radius}, ambient);
    const Aperture back = unpackAperture64(code.x | static_cast<std::uint64_t>(code.y) << 32);
    worst = std::max(worst, static_cast<double>(glm::distance(back.direction, axis)));
    EXPECT_NEAR(back.radius, radius, 1.3e-5f);
    EXPECT_NEAR(shared::ambientFromWord(code.y), ambient, 8e-6f);
  }
  EXPECT_LT(worst, 1e-4);
}

TEST(ApertureFormulas, LampsInFullViewGiveTheirSineSquared) {
  // Lambert: a cap of radius r at height h over the horizon, all of it above, has the form factor sin^2(r) cos(h), however near the lamp.
  const glm::vec3 normal(0, 1, 0);
  const glm::vec4 open(normal, shared::kApertureWidest);
  for (const double radius : {0.01, 0.3, 0.8, 1.2})
    for (double tilt = 0.0; tilt + radius < 0.5 * kPi; tilt += 0.1) {
      const double expected = kPi * std::pow(std::sin(radius), 2.0) * std::cos(tilt);
      for (const int mode : {shared::kApertureExact, shared::kApertureFast, shared::kApertureAccurate}) {
        const auto share = shared::apertureShare(mode, normal, open, {tilted(tilt, 1.1), static_cast<float>(radius)});
        EXPECT_NEAR(share.cosine / expected, 1.0, 2e-3) << "mode " << mode << ", radius " << radius << ", tilt " << tilt;
      }
    }
}

TEST(ApertureFormulas, ConesAreAsClearAsDiscsBesideAChord) {
  for (double x = -1.0; x <= 1.0; x += 0.05) {
    const double segment = 0.5 + (x * std::sqrt(std::max(1.0 - x * x, 0.0)) + std::asin(std::clamp(x, -1.0, 1.0))) / kPi;
    EXPECT_NEAR(shared::coneClear(static_cast<float>(x)), segment, 0.013) << x;
  }
  EXPECT_EQ(shared::coneClear(-7.0f), 0.0f);
  EXPECT_EQ(shared::coneClear(1e4f), 1.0f);
}

TEST(ApertureFormulas, ConesFindTheLeastBetweenSteps) {
  // Past a point at a distance of 0.4, in steps of 0.5 wherever they fall.
  for (double shift = 0.0; shift < 0.5; shift += 0.05) {
    double least = 1e9, stepped = 1e9;
    glm::vec2 first(0.0f), second(0.0f);
    for (int i = 0; i < 8; ++i) {
      const double t = shift + 0.5 * i, phi = std::hypot(t - 2.0, 0.4);
      const glm::vec2 third(static_cast<float>(t), static_cast<float>(phi));
      stepped = std::min(stepped, phi);
      least = std::min({least, phi, i > 1 ? static_cast<double>(shared::coneLeast(first, second, third)) : 1e9});
      first = second;
      second = third;
    }
    EXPECT_NEAR(least, 0.4, 0.025) << shift << ": steps alone are off by up to 0.07";
    EXPECT_LE(least, stepped);
  }
  EXPECT_EQ(shared::coneLeast({0.0f, 3.0f}, {1.0f, 2.0f}, {2.0f, 1.0f}), 1.0f) << "still falling";
}

TEST(ApertureFormulas, SkyFillsWhatLightsLeave) {
  EXPECT_EQ(shared::skyShare(1.0f, 0.0f), 1.0f);
  EXPECT_NEAR(shared::skyShare(1.0f, 0.25f * shared::capArea(1.0f)), 0.75f, 1e-6f);
  EXPECT_EQ(shared::skyShare(1.0f, 9.0f), 0.0f) << "lights that overlap cover no more than there is";
  EXPECT_EQ(shared::skyShare(0.0f, 0.0f), 1.0f);
}

class Apertures : public Frames {
 protected:
  void openMode(const Scene& made, ApertureMode mode, const std::optional<std::string>& estimator = {}) {
    const fs::path file = temporaryFolder() / "apertures.gltf";
    const auto written = writeScene(file, made);
    ASSERT_TRUE(written.ok()) << message(written.error());
    settings = {64, 48, 1, {}, {}, mode};
    settings.estimator = estimator;
    open(file, settings);
  }
  Image picture(const View& view, double time = 0.0) {
    EXPECT_TRUE(renderFrame(device, renderer, scene, time, view).ok());
    return linear();
  }
};

/// Light of a floor point with this aperture, by counting directions.
glm::dvec3 expectedLight(const Lighting& lighting, const glm::vec4& albedo, const Aperture& aperture, double ambient,
                         const glm::dvec3& point) {
  const glm::dvec3 normal(0, 1, 0);
  glm::dvec3 received(0.0);
  double covered = 0.0;
  const auto add = [&](const glm::dvec3& axis, double radius, const glm::dvec3& radiance) {
    const reference::CapMoments share = reference::capMoments(normal, aperture.direction, aperture.radius, axis, radius, 150);
    received += radiance * share.cosine / kPi;
    covered += share.area;
  };
  for (const AreaLight& light : lighting.areaLights) {
    const glm::dvec3 way = glm::dvec3(light.position) - point;
    add(glm::normalize(way), std::asin(light.radius / glm::length(way)), light.colour);
  }
  const double sun = lighting.sun->angularRadius;
  add(lighting.sun->direction, sun, glm::dvec3(lighting.sun->colour) / static_cast<double>(reference::capArea(sun)));
  const double whole = static_cast<double>(reference::capArea(aperture.radius));
  received += glm::dvec3(lighting.skyColour) * ambient * std::max(0.0, 1.0 - covered / whole);
  return received * glm::dvec3(albedo);
}

/// Where the middle of a pixel of a 64 x 48 picture from above meets the floor.
glm::dvec3 floorPoint(const glm::ivec2& pixel) {
  const glm::dmat4 relativeFromClip = glm::inverse(clipFromRelative(fromAbove(), 64.0 / 48.0));
  const glm::dvec4 far = relativeFromClip * glm::dvec4((pixel.x + 0.5) / 32.0 - 1.0, (pixel.y + 0.5) / 24.0 - 1.0, 0.5, 1.0);
  const glm::dvec3 ray = glm::dvec3(far) / far.w, from = eye(fromAbove());
  return from - ray * (from.y / ray.y);
}

TEST_F(Apertures, LightTheFloorAsCountedDirectionsDo) {
  const Aperture aperture{tilted(0.5, 0.8), 0.9f};
  const float ambient = 0.4f;
  const Scene made = floorScene(temporaryFolder(), square(aperture, ambient));
  std::vector<std::pair<glm::ivec2, glm::dvec3>> expected;
  for (const int x : {12, 22, 32, 43, 52})
    for (const int y : {8, 19, 30, 41})
      expected.emplace_back(glm::ivec2(x, y),
                            expectedLight(*made.lighting, made.materials[0].baseColour, aperture, ambient, floorPoint({x, y})));
  // The published model takes the cosine at the mean of both axes, the others at the centre of what they share.
  const std::array<double, 4> tolerances{0.02, 0.15, 0.02, 0.005};
  std::array<double, 4> worst{};
  for (std::size_t m = 0; m < kModes.size(); ++m) {
    openMode(made, kModes[m]);
    const Image image = picture(fromAbove());
    for (const auto& [pixel, light] : expected) {
      for (int c = 0; c < 3; ++c)
        worst[m] = std::max(worst[m], std::abs(static_cast<double>(at(image, pixel.x, pixel.y, c)) - light[c]) / light[c]);
      EXPECT_NEAR(at(image, pixel.x, pixel.y, channelIndex(image, "sky")), ambient, 1e-3f);
    }
    RecordProperty("mode" + std::to_string(m), std::to_string(worst[m]));
    EXPECT_LT(worst[m], tolerances[m]) << "mode " << m;
    close();
  }
  EXPECT_LT(worst[3], worst[0]);
  EXPECT_LT(worst[2], 0.5 * worst[1]) << "ours beats the published model";
}

TEST_F(Apertures, TurnWithTheirObjects) {
  const Aperture aperture{tilted(0.6, 0.0), 0.5f}, turned{tilted(0.6, 0.5 * kPi), 0.5f};
  Scene still = floorScene(temporaryFolder(), square(turned, 0.3f));
  openMode(still, ApertureMode::accurate);
  const Image expected = picture(fromAbove());
  close();
  Scene moving = floorScene(temporaryFolder(), square(aperture, 0.3f));
  AnimationChannel channel;
  channel.property = AnimatedProperty::rotation;
  channel.node = 0;
  channel.times = {0.0, 1.0};
  const double half = std::sqrt(0.5);
  channel.values = {{0, 0, 0, 1}, {0, -half, 0, half}};  // a quarter turn that takes x to z
  moving.animations.push_back({"turn", {channel}});
  openMode(moving, ApertureMode::accurate);
  const Image image = picture(fromAbove(), 1.0 - 1e-9), before = picture(fromAbove(), 0.0);
  float worst = 0.0f, changed = 0.0f;
  for (const double x : {-1.0, 0.0, 1.0}) {
    const glm::ivec2 pixel = pixelOf(renderer, fromAbove(), {x, 0.0, 0.2});
    for (int c = 0; c < 3; ++c) {
      worst = std::max(worst, std::abs(at(image, pixel.x, pixel.y, c) - at(expected, pixel.x, pixel.y, c)));
      changed = std::max(changed, std::abs(at(before, pixel.x, pixel.y, c) - at(expected, pixel.x, pixel.y, c)));
    }
  }
  EXPECT_LT(worst, 2e-3f);
  EXPECT_GT(changed, 0.02f);
}

TEST_F(Apertures, AreNeverBelowZeroNorNotANumber) {
  Scene made = floorScene(temporaryFolder(), reference::icosphere(1.5, 3));
  Mesh& mesh = made.meshes[0];
  mesh.parts = {{0, static_cast<std::uint32_t>(mesh.triangles.size()), 0}};
  mesh.visibility.emplace();
  mesh.visibility->bits = ApertureBits::packed64;
  mesh.normals.clear();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.normals.emplace_back(glm::normalize(mesh.positions[i]));
    const float radius = i % 3 == 0 ? 0.0f : i % 3 == 1 ? shared::kApertureWidest : 1e-3f * static_cast<float>(i);
    mesh.visibility->apertures.push_back({i % 5 == 0 ? -mesh.normals[i] : mesh.normals[i], std::min(radius, shared::kApertureWidest)});
    mesh.visibility->ambient.push_back(i % 2 ? 0.0f : 1.0f);
  }
  made.lighting->areaLights = {
      {{0, 0, 0}, 0.3f, {1, 1, 1}}, {{0, 1.5f, 0}, 1e-6f, {1, 1, 1}}, {{0, 1.4f, 0.3f}, 3.0f, {1, 1, 1}}, {{0, 1e6f, 0}, 1.0f, {1, 1, 1}}};
  for (const ApertureMode mode : kModes) {
    openMode(made, mode);
    const Image image = picture(lookAt({0.0, 4.0, 3.0}, {0.0, 0.0, 0.0}, {0, 1, 0}, 0.8));
    for (const float value : image.pixels) ASSERT_TRUE(value >= 0.0f && value < 1e4f) << value;
    close();
  }
}

/// bakedScene's floor with open apertures and its ball over it.
Scene ballOverFloor(const fs::path& folder, const glm::dvec3& ball) {
  Scene scene = bakedScene(folder, {.animated = false, .camera = false, .resolution = 128});
  scene.nodes.resize(2);
  Mesh& floor = scene.meshes[0];
  const std::size_t vertices = floor.positions.size();
  floor.normals.assign(vertices, {0, 1, 0});
  floor.visibility = VertexVisibility{ApertureBits::packed64,
                                      std::vector<Aperture>(vertices, Aperture{{0, 1, 0}, shared::kApertureWidest}),
                                      std::vector<float>(vertices, 1.0f),
                                      {}};
  scene.nodes[1].translation = ball;
  return scene;
}

TEST_F(Apertures, LightsAreShadowedByOtherObjectsOnly) {
  // A ball over the floor, a lamp above: the share of the lamp that the ball leaves is known from caps.
  const glm::dvec3 ball(0.0, 0.8, 0.0), lamp(0.6, 3.5, 0.2);
  Scene made = ballOverFloor(temporaryFolder(), ball);
  made.lighting->skyColour = {0, 0, 0};
  for (const double size : {0.05, 0.6}) {
    made.lighting->areaLights = {{glm::vec3(lamp), static_cast<float>(size), {10, 10, 10}}};
    openMode(made, ApertureMode::accurate);
    const View view = lookAt({0.0, 5.0, 4.0}, {0.0, 0.0, 0.0}, {0, 1, 0}, 0.6);
    ASSERT_TRUE(resizeFrames(device, renderer, 160, 120).ok());
    const Image image = picture(view);
    double squares = 0.0;
    int count = 0, shadowed = 0;
    for (double x = -1.5; x < 1.5; x += 0.1) {
      const glm::dvec3 point(x, 0.0, 0.55);
      const glm::dvec3 toLamp = lamp - point, toBall = ball - point;
      const double lampRadius = std::asin(size / glm::length(toLamp)), ballRadius = std::asin(0.5 / glm::length(toBall));
      const double apart = std::acos(glm::dot(glm::normalize(toLamp), glm::normalize(toBall)));
      const double clear =
          1.0 - static_cast<double>(reference::capIntersection(lampRadius, ballRadius, apart) / reference::capArea(lampRadius));
      const double open =
          10.0 * std::pow(std::sin(lampRadius), 2.0) * glm::normalize(toLamp).y * static_cast<double>(made.materials[0].baseColour.x);
      const glm::ivec2 pixel = pixelOf(renderer, view, point);
      squares += std::pow(static_cast<double>(at(image, pixel.x, pixel.y, 0)) / open - clear, 2.0);
      shadowed += clear < 0.5;
      ++count;
    }
    EXPECT_GT(shadowed, 3);
    const double error = std::sqrt(squares / count);
    RecordProperty(size < 0.1 ? "small" : "large", std::to_string(error));
    EXPECT_LT(error, 0.03) << "lamp of radius " << size;
    close();
  }
}

TEST_F(Apertures, LampsBeforeWallsAreNotHiddenByThem) {
  // Apertures that see straight up alone, and a lamp aside. Where they are the object's own, it hides the lamp. Where other objects narrow
  // them they tell of the sky behind the lamp, and the volume, in which nothing stands before it, has the word.
  Scene made = ballOverFloor(temporaryFolder(), {-1.5, 0.5, -1.5});
  made.lighting->skyColour = {0, 0, 0};
  const glm::ivec2 pixel(30, 24);
  const glm::dvec3 lamp(1.2, 0.9, 0.0), point = floorPoint(pixel);
  made.lighting->areaLights = {{glm::vec3(lamp), 0.2f, {10, 10, 10}}};
  const double way = glm::length(lamp - point);
  const double whole = 10.0 * std::pow(0.2 / way, 2.0) * (lamp.y / way) * static_cast<double>(made.materials[0].baseColour.x);
  for (Aperture& aperture : made.meshes[0].visibility->apertures) aperture.radius = 0.3f;
  made.meshes[1].normals.assign(made.meshes[1].positions.size(), {0, 1, 0});
  made.meshes[1].visibility = VertexVisibility{ApertureBits::packed64,
                                               std::vector<Aperture>(made.meshes[1].positions.size(), Aperture{{0, 1, 0}, 1.5f}),
                                               std::vector<float>(made.meshes[1].positions.size(), 1.0f),
                                               {}};
  for (const bool others : {false, true}) {
    for (int mesh = 0; mesh < 2; ++mesh) made.meshes[static_cast<std::size_t>(mesh)].apertureBake.emplace().sceneOccludes = others;
    openMode(made, ApertureMode::fast);
    const Image image = picture(fromAbove());
    const double share = static_cast<double>(at(image, pixel.x, pixel.y, 0)) / whole;
    EXPECT_NEAR(share, others ? 1.0 - static_cast<double>(shared::kLampKnown) : 0.0, 0.03);
    close();
  }
}

TEST_F(Apertures, SkyIsWhatOtherObjectsLeave) {
  const glm::dvec3 ball(0.0, 0.8, 0.0);
  openMode(ballOverFloor(temporaryFolder(), ball), ApertureMode::exact);
  const View view = lookAt({0.0, 5.0, 4.0}, {0.0, 0.0, 0.0}, {0, 1, 0}, 0.6);
  ASSERT_TRUE(resizeFrames(device, renderer, 160, 120).ok());
  const Image image = picture(view);
  double squares = 0.0, covered = 0.0;
  int count = 0;
  for (double x = -1.6; x < 1.6; x += 0.1, ++count) {
    const glm::dvec3 point(x, 0.0, 0.55), way = ball - point;
    // The form factor of a sphere above the horizon.
    const double taken = 0.25 * way.y / std::pow(glm::length(way), 3.0);
    const glm::ivec2 pixel = pixelOf(renderer, view, point);
    squares += std::pow(static_cast<double>(at(image, pixel.x, pixel.y, channelIndex(image, "sky"))) - (1.0 - taken), 2.0);
    covered += taken * taken;
  }
  RecordProperty("rmse", std::to_string(std::sqrt(squares / count)));
  EXPECT_LT(squares, 0.25 * covered) << "half the error of leaving the ball out";
}

TEST_F(Apertures, AreLeftOutByEstimatorsThatAreNoHybrids) {
  const Scene made = floorScene(temporaryFolder(), square({{0, 1, 0}, 1.0f}, 0.5f));
  const View view = lookAt({0.0, 5.0, 4.0}, {0.0, 0.0, 0.0}, {0, 1, 0}, 0.6);
  for (const char* name : kEstimators) {
    openMode(made, ApertureMode::accurate, name);
    const Image image = picture(view);
    const glm::ivec2 pixel = pixelOf(renderer, view, {0.0, 0.0, 0.0});
    const float sky = at(image, pixel.x, pixel.y, channelIndex(image, "sky"));
    EXPECT_EQ(std::abs(sky - 0.5f) < 0.01f, isHybrid(name)) << name << " finds " << sky << ", apertures say half";
    EXPECT_EQ(renderer.targets.images.aperture.image != VK_NULL_HANDLE, isHybrid(name));
    close();
  }
}

TEST_F(Apertures, MeshesWithoutAreLitAsTheEstimatorSays) {
  // Beside a mesh with apertures, far below, the floor has none: what the estimator says is all there is, and nearly that of open ones.
  Scene made = floorScene(temporaryFolder(), square({{0, 1, 0}, shared::kApertureWidest}, 1.0f));
  made.lighting->globalVolume.bounds = Box{{-2.0, -0.5, -2.0}, {2.0, 1.5, 2.0}};
  for (glm::dvec3& position : made.meshes[0].positions) position.y = 0.1;  // on top of its occluder
  made.meshes.push_back(made.meshes[0]);
  Node below = made.nodes[0];
  below.mesh = 1;
  below.translation = {0.0, -1000.0, 0.0};
  made.nodes.push_back(below);
  openMode(made, ApertureMode::accurate);
  const Image open = picture(fromAbove());
  close();
  made.meshes[0].visibility.reset();
  openMode(made, ApertureMode::accurate);
  const Image bare = picture(fromAbove());
  close();
  openMode(made, ApertureMode::accurate, "traced");
  const Image alone = picture(fromAbove());  // of the sky; without apertures sun and lamps go unseen
  const int sky = channelIndex(bare, "sky");
  for (int y = 0; y < bare.height; ++y)
    for (int x = 0; x < bare.width; ++x) ASSERT_EQ(at(bare, x, y, sky), at(alone, x, y, sky)) << x << " " << y;
  for (const double x : {-0.8, 0.0, 0.9}) {
    const glm::ivec2 pixel = pixelOf(renderer, fromAbove(), {x, 0.0, 0.2});
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(at(bare, pixel.x, pixel.y, c), at(open, pixel.x, pixel.y, c), 0.02f);
  }
}

TEST_F(Apertures, SeeTheDayPassAndLampsMove) {
  Scene made = floorScene(temporaryFolder(), square({{0, 1, 0}, 1.4f}, 0.9f));
  made.lighting->areaLights = {{{0.0f, 0.8f, 0.0f}, 0.3f, {2, 2, 2}, 1}};
  Node& lamp = made.nodes.emplace_back();
  lamp.name = "lamp";
  AnimationChannel channel;
  channel.node = 1;
  channel.times = {0.0, 1.0};
  channel.values = {{-1.0, 0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  made.animations.push_back({"lamp", {channel}});
  const fs::path file = temporaryFolder() / "moving.gltf";
  ASSERT_TRUE(writeScene(file, made).ok());
  open(file, {64, 48, 1, {}, {}, ApertureMode::fast, Daylight{12.0, 12.0}});
  const Image noon = picture(fromAbove(), 0.0), night = picture(fromAbove(), 1.0 - 1e-9);
  const glm::ivec2 left = pixelOf(renderer, fromAbove(), {-1.0, 0.0, 0.0}), right = pixelOf(renderer, fromAbove(), {1.0, 0.0, 0.0});
  EXPECT_GT(at(noon, left.x, left.y, 1), at(noon, right.x, right.y, 1) + 0.05f) << "the lamp stands on the left";
  EXPECT_GT(at(night, right.x, right.y, 1), at(night, left.x, left.y, 1) + 0.05f) << "and is gone to the right";
  EXPECT_LT(at(night, left.x, left.y, 1), 0.1f) << "where it is night";
  EXPECT_GT(at(noon, right.x, right.y, 1), 0.3f);
}

TEST_F(Apertures, CostNothingWhereThereAreNone) {
  settings.estimator = "published";  // what takes turns has a pass more
  open(writeBakedScene(temporaryFolder()), settings);
  EXPECT_FALSE(renderer.targets.aperture.has_value());
  EXPECT_EQ(renderer.targets.images.aperture.image, VK_NULL_HANDLE);
  EXPECT_EQ(scene.apertures.buffer, VK_NULL_HANDLE);
  EXPECT_EQ(renderer.geometry.pipeline.bindings.size(), 2u);
  EXPECT_EQ(render(0.0).size(), 5u);
  close();
  openMode(floorScene(temporaryFolder(), square({{0, 1, 0}, 1.0f}, 0.5f)), ApertureMode::fast);
  EXPECT_TRUE(renderer.targets.aperture.has_value());
  EXPECT_EQ(render(0.0).size(), 6u);
}

TEST_F(Apertures, KeepTheirSizeWhenThePictureChanges) {
  openMode(floorScene(temporaryFolder(), square({{0, 1, 0}, 1.0f}, 0.5f)), ApertureMode::fast);
  ASSERT_TRUE(resizeFrames(device, renderer, 32, 32).ok());
  EXPECT_TRUE(renderer.targets.aperture.has_value());
  EXPECT_EQ(render(0.0).size(), 6u);
}

TEST_F(Apertures, RefuseMoreLightsThanThereIsRoomFor) {
  Scene made = floorScene(temporaryFolder(), square({{0, 1, 0}, 1.0f}, 0.5f));
  made.lighting->areaLights.assign(17, AreaLight{});
  ASSERT_TRUE(writeScene(temporaryFolder() / "many.gltf", made).ok());
  const Result<RuntimeScene> loaded = loadScene(device, temporaryFolder() / "many.gltf");
  ASSERT_FALSE(loaded.ok());
  EXPECT_NE(message(loaded.error()).find("17 area lights"), std::string::npos) << message(loaded.error());
}

}  // namespace
}  // namespace overcast::test
