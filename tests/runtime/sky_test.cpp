// Sky light by harmonics: through caps against counted directions, and by transfer through whole frames.
#include "runtime/sky_light.h"

#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/runtime/baked_scene.h"
#include "tests/runtime/frames.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;

constexpr double kPi = std::numbers::pi;

/// L(w) = 2 + gradient . w + w^T Q w, told without harmonics.
struct PolynomialSky {
  glm::dvec3 gradient{0.6, 0.5, -0.4};
  glm::dmat3 quadratic{0.3, 0.2, -0.1, 0.2, -0.5, 0.15, -0.1, 0.15, 0.2};
  double operator()(const glm::dvec3& w) const { return 2.0 + glm::dot(gradient, w) + glm::dot(w, quadratic * w); }
};

/// Its harmonics by way of an image.
SkyHarmonics harmonicsOf(const PolynomialSky& sky) {
  constexpr int kHeight = 256;
  Image image{2 * kHeight, kHeight, {"Y"}, {}};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < 2 * kHeight; ++x) {
      const double longitude = kPi * (1.0 - (x + 0.5) / kHeight), latitude = kPi * (0.5 - (y + 0.5) / kHeight);
      image.pixels.push_back(static_cast<float>(
          sky({std::cos(latitude) * std::sin(longitude), std::sin(latitude), std::cos(latitude) * std::cos(longitude)})));
    }
  return skyHarmonics(image).value();
}

/// Mean of the sky under the cosine to `normal` over what lies in a cap and above the horizon.
double counted(const PolynomialSky& sky, const glm::dvec3& normal, const glm::dvec3& axis, double radius) {
  constexpr int kPoints = 200000;
  const glm::dvec3 side = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
  double sum = 0.0, cosines = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    const double h = (1.0 - std::cos(radius)) * (i + 0.5) / kPoints, sine = std::sqrt(h * (2.0 - h)), angle = 2.39996322972865332 * i;
    const glm::dvec3 w = (1.0 - h) * axis + sine * (std::cos(angle) * side + std::sin(angle) * glm::cross(axis, side));
    const double cosine = std::max(glm::dot(w, normal), 0.0);
    sum += cosine * sky(w);
    cosines += cosine;
  }
  return sum / cosines;
}

glm::dvec3 directionOf(double angle, double azimuth) {
  return {std::sin(angle) * std::cos(azimuth), std::cos(angle), std::sin(angle) * std::sin(azimuth)};
}

TEST(SkyThrough, CapsAboveTheHorizonIsExact) {
  const PolynomialSky sky;
  const shared::SkyLight light = skyLight(harmonicsOf(sky));
  double worst = 0.0;
  for (const auto& [tilt, radius] : {std::pair(0.0, 0.5 * kPi), {0.0, 0.8}, {0.5, 1.0}, {1.0, 0.5}, {1.3, 0.2}, {0.3, 0.01}})
    for (const double azimuth : {0.3, 2.0, 4.0}) {
      const glm::dvec3 normal = directionOf(0.7, 1.0);
      const glm::dvec3 side = glm::normalize(glm::cross(normal, directionOf(1.2, azimuth)));
      const glm::dvec3 axis = std::cos(tilt) * normal + std::sin(tilt) * side;
      const double truth = counted(sky, normal, axis, radius);
      const glm::vec3 ours = shared::skyThrough(light, normal, {glm::vec3(axis), static_cast<float>(radius)});
      worst = std::max(worst, std::abs(static_cast<double>(ours.x) - truth));
      if (tilt == 0.0 && radius > 1.5) {
        EXPECT_NEAR(shared::skyOverOpen(light, normal).x, truth, 1e-3);
      }
    }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_LT(worst, 1e-3);
}

TEST(SkyThrough, CapsThatDipBelowTheHorizonAreNearWhatIsAbove) {
  const PolynomialSky sky;
  const shared::SkyLight light = skyLight(harmonicsOf(sky));
  double squares = 0.0, plain = 0.0;
  // What an open wall leaves: its mean direction and area, and the sky over the quarter that is left.
  for (int i = 0; i < 12; ++i) {
    const glm::dvec3 normal = directionOf(0.4, 0.5 * i), wall = glm::normalize(glm::cross(normal, directionOf(1.0, 0.9 * i)));
    const glm::dvec3 axis = glm::normalize(normal + wall);
    double sum = 0.0, cosines = 0.0;
    const glm::dvec3 side = glm::cross(normal, wall);
    for (int k = 0; k < 100000; ++k) {
      const double z = (k + 0.5) / 100000, sine = std::sqrt(1.0 - z * z), angle = 2.39996322972865332 * k;
      if (std::cos(angle) < 0.0) continue;
      sum += z * sky(z * normal + sine * (std::cos(angle) * wall + std::sin(angle) * side));
      cosines += z;
    }
    const double ours = static_cast<double>(shared::skyThrough(light, normal, {glm::vec3(axis), static_cast<float>(kPi / 3.0)}).x);
    squares += std::pow(ours - sum / cosines, 2.0);
    plain += std::pow(2.0 - sum / cosines, 2.0);
  }
  RecordProperty("share", std::to_string(std::sqrt(squares / plain)));
  EXPECT_LT(squares, 0.04 * plain) << "a fifth of the error of a uniform sky";
}

TEST(SkyThrough, IsNeverBelowZeroNorNotANumber) {
  SkyHarmonics sky;  // a single bright point rings
  for (std::size_t i = 0; i < 9; ++i)
    sky.coefficients[i] = glm::vec3(i == 0 ? 0.28f : i == 1 ? 0.49f : i == 6 ? -0.32f : i == 8 ? -0.55f : 0.0f);
  const shared::SkyLight light = skyLight(sky);
  int dark = 0;
  for (double tilt = 0.0; tilt < kPi; tilt += 0.1)
    for (const double radius : {0.0, 1e-4, 0.5, 0.5 * kPi}) {
      const glm::vec4 aperture(glm::vec3(directionOf(tilt, 1.0)), static_cast<float>(radius));
      for (const glm::dvec3& normal : {directionOf(0.0, 0.0), directionOf(kPi, 0.0), directionOf(tilt, 1.0)}) {
        const float value = shared::skyThrough(light, normal, aperture).x;
        EXPECT_TRUE(value >= 0.0f && value < 10.0f) << value;
        dark += value == 0.0f;
      }
    }
  EXPECT_GT(dark, 0);
}

TEST(SkyLight, TurnsAgainstTheObjectWhateverItsScale) {
  const SkyHarmonics sky = harmonicsOf({});
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1.0), 1.1, glm::normalize(glm::dvec3(1, 2, 3)));
  const shared::SkyLight local = skyLight(sky, glm::scale(turn, {1e-4, 5e-4, 2e-4}));
  const glm::dvec3 w = directionOf(1.0, 2.0);
  EXPECT_NEAR(shared::skyRadiance(local, w).x, static_cast<float>(PolynomialSky{}(glm::dmat3(turn) * w)), 1e-3f);
  const shared::SkyLight mirrored = skyLight(sky, glm::scale(turn, {-2.0, 2.0, 2.0}));
  const glm::dvec3 mirror(-w.x, w.y, w.z);
  EXPECT_NEAR(shared::skyRadiance(mirrored, w).x, static_cast<float>(PolynomialSky{}(glm::dmat3(turn) * mirror)), 1e-3f);
  for (const glm::dmat4& broken : {glm::dmat4(0.0), glm::scale(turn, {1.0, 0.0, 1.0})})
    EXPECT_TRUE(std::isfinite(skyLight(sky, broken).coefficients[4].x));
}

/// The harmonics of the clamped cosine about a normal, over pi: the transfer of an open point (Ramamoorthi and Hanrahan 2001).
std::array<float, 9> openTransfer(const glm::dvec3& n) {
  const double k = 0.5 / std::sqrt(kPi);
  const std::array<double, 9> y{1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3.0 * n.z * n.z - 1.0, n.x * n.z, n.x * n.x - n.y * n.y};
  const double first = 2.0 / 3.0 * std::sqrt(3.0), mixed = 0.25 * std::sqrt(15.0);
  const std::array<double, 9> weights{1.0, first, first, first, mixed, mixed, 0.125 * std::sqrt(5.0), mixed, 0.5 * mixed};
  std::array<float, 9> transfer{};
  for (std::size_t i = 0; i < 9; ++i) transfer[i] = static_cast<float>(k * weights[i] * y[i]);
  return transfer;
}

/// A lone ball with transfer, and with apertures or without.
Scene ballScene(const fs::path& folder, bool transfer) {
  Scene scene = bakedScene(folder, {});
  scene.nodes.erase(scene.nodes.begin());
  scene.nodes.resize(1);
  scene.nodes[0].translation = {0.0, 0.0, 0.0};
  Mesh& ball = scene.meshes[1];
  VertexVisibility& visibility = ball.visibility.emplace();
  visibility.bits = ApertureBits::packed64;
  ball.normals.clear();
  for (const glm::dvec3& position : ball.positions) {
    const glm::dvec3 normal = glm::normalize(position);
    ball.normals.emplace_back(normal);
    visibility.apertures.push_back({glm::vec3(normal), shared::kCapRightAngle});
    visibility.ambient.push_back(1.0f);
    if (transfer) visibility.transfer.push_back(openTransfer(normal));
  }
  return scene;
}

class SkyFrames : public Frames {
 protected:
  Image picture(const Scene& made, const std::optional<SkyHarmonics>& sky) {
    close();
    const fs::path file = temporaryFolder() / "ball.gltf";
    const auto written = writeScene(file, made);
    EXPECT_TRUE(written.ok());
    open(file, {64, 48, 1, {}, {}}, sky);
    EXPECT_TRUE(renderFrame(device, renderer, scene, 0.0, view()).ok());
    return linear();
  }
  static View view() { return lookAt({0.6, 1.0, 2.0}, {0.0, 0.0, 0.0}, {0, 1, 0}, 0.6); }
  /// Largest difference over pixels whose surface `wanted` knows: at unit normals of the ball.
  template <class Wanted>
  double worst(const Image& image, const Wanted& wanted) const {
    double largest = 0.0;
    for (double tilt = 0.1; tilt < 3.0; tilt += 0.3)
      for (double azimuth = 0.0; azimuth < 6.0; azimuth += 0.4) {
        const glm::dvec3 normal = directionOf(tilt, azimuth);
        if (glm::dot(normal, glm::normalize(eye(view()) - 0.5 * normal)) < 0.4) continue;
        const glm::ivec2 pixel = pixelOf(renderer, view(), 0.5 * normal);
        largest = std::max(largest, std::abs(static_cast<double>(at(image, pixel.x, pixel.y, 0)) - wanted(normal)));
      }
    return largest;
  }
};

TEST_F(SkyFrames, OpenBallsGetTheIrradianceOfTheSkyByTransferAndThroughApertures) {
  const PolynomialSky sky;
  for (const bool transfer : {true, false}) {
    Scene made = ballScene(temporaryFolder(), transfer);
    const double albedo = static_cast<double>(made.materials[1].baseColour.x);
    const auto irradiance = [&](const glm::dvec3& n) {
      return albedo * (2.0 + 2.0 / 3.0 * glm::dot(sky.gradient, n) + 0.25 * glm::dot(n, sky.quadratic * n));
    };
    const Image image = picture(made, harmonicsOf(sky));
    // A pixel is 1/25 of the ball's diameter wide.
    EXPECT_LT(worst(image, irradiance), 0.04) << transfer;
    EXPECT_GT(worst(image, [&](const glm::dvec3&) { return 2.0 * albedo; }), 0.3) << "the sky is far from uniform";
    EXPECT_LT(worst(picture(ballScene(temporaryFolder(), transfer), uniformSky(glm::vec3(1.5f))),
                    [&](const glm::dvec3&) { return 1.5 * albedo; }),
              6e-3)
        << "a furnace, but for the 8 bits of the base colour";
  }
}

TEST_F(SkyFrames, TurningTheObjectIsTurningTheSkyTheOtherWay) {
  // Transfer that is not the same all round: what faces local +x sees nothing of the sky towards +y.
  Scene made = ballScene(temporaryFolder(), true);
  VertexVisibility& visibility = *made.meshes[1].visibility;
  for (std::size_t i = 0; i < visibility.transfer.size(); ++i)
    for (std::size_t k = 1; k < 9; ++k) visibility.transfer[i][k] *= 1.0f + 0.5f * made.meshes[1].normals[i].x * (k == 1 ? -1.0f : 1.0f);
  const SkyHarmonics sky = harmonicsOf({});
  const glm::dquat turn = glm::angleAxis(1.9, glm::normalize(glm::dvec3(1, 3, -2)));
  const Image still = picture(made, turned(sky, glm::transpose(glm::mat3_cast(turn))));
  std::vector<std::pair<glm::dvec3, double>> seen;
  for (double tilt = 0.2; tilt < 3.0; tilt += 0.1)
    for (double azimuth = 0.0; azimuth < 6.2; azimuth += 0.1) {
      const glm::dvec3 n = directionOf(tilt, azimuth), moved = turn * n;
      if (glm::dot(n, glm::normalize(eye(view()))) < 0.5 || glm::dot(moved, glm::normalize(eye(view()))) < 0.5) continue;
      const glm::ivec2 pixel = pixelOf(renderer, view(), 0.5 * n);
      seen.emplace_back(moved, at(still, pixel.x, pixel.y, 0));
    }
  ASSERT_GT(seen.size(), 10u);
  made.nodes[0].rotation = turn;
  const Image rotated = picture(made, sky);
  for (const auto& [n, value] : seen) {
    const glm::ivec2 pixel = pixelOf(renderer, view(), 0.5 * n);
    EXPECT_NEAR(at(rotated, pixel.x, pixel.y, 0), value, 0.05);
  }
}

TEST_F(SkyFrames, ScenesNameTheirSkyAndScenesWithoutAperturesHaveItToo) {
  ASSERT_TRUE(writeExr(temporaryFolder() / "grey sky.exr", {4, 2, {"R", "G", "B"}, std::vector<float>(24, 0.7f)}));
  for (const bool apertures : {true, false}) {
    Scene made = ballScene(temporaryFolder(), false);
    made.lighting->estimator.name = "published";  // whose taps see less than all of the sky from a ball, which rays do not
    if (!apertures) made.meshes[1].visibility.reset();
    made.lighting->skyColour = glm::vec3(0.7f);
    const Image uniform = picture(made, {});
    made.lighting->skyColour = glm::vec3(0.1f);
    made.lighting->skyImage = "grey sky.exr";
    const Image named = picture(made, {});
    int surfaces = 0;
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) {
        if (at(uniform, x, y, 3) == 1.0f && !apertures) continue;
        const glm::dvec2 offset(x - 32, y - 24);
        if (glm::length(offset) > 12.0) continue;
        ++surfaces;
        EXPECT_NEAR(at(named, x, y, 0), at(uniform, x, y, 0), 2e-3f);
      }
    EXPECT_GT(surfaces, 20);
    EXPECT_NEAR(at(named, 1, 1, 0), 0.7f, 1e-3f) << "the sky is behind the scene";
    close();
  }
  Scene lost = ballScene(temporaryFolder(), false);
  lost.lighting->skyImage = "gone.exr";
  ASSERT_TRUE(writeScene(temporaryFolder() / "lost.gltf", lost).ok());
  const auto refused = loadScene(device, temporaryFolder() / "lost.gltf");
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(message(refused.error()).find("gone.exr"), std::string::npos);
}

}  // namespace
}  // namespace overcast::test
