// Ambient occlusion in screen space: its closed forms against sums in double, then the pass over depth images of analytic scenes.
#include "runtime/passes/gtao/gtao.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>

#include "formats/camera.h"
#include "runtime/baseline.h"
#include "runtime/passes/denoise/denoise_pass.h"
#include "tests/runtime/ground.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(GtaoFormulas, ASliceIsTheCosineWeightedIntegralOfWhatIsVisible) {
  for (double n = -1.4; n <= 1.4; n += 0.2)
    for (double low = 0.1; low <= kPi; low += 0.3)
      for (double high = 0.1; high <= kPi; high += 0.3) {
        double sum = 0.0;
        constexpr int kSteps = 4000;
        for (int i = 0; i < kSteps; ++i) {
          const double angle = kPi * (2.0 * (i + 0.5) / kSteps - 1.0);
          if (angle < -low || angle > high) continue;
          sum += std::max(std::cos(angle - n), 0.0) * std::abs(std::sin(angle)) * 2.0 * kPi / kSteps;
        }
        // A horizon on the far side of the normal's own leaves a negative arc there, as in the paper.
        if (-low > n + kPi / 2 || high < n - kPi / 2) continue;
        ASSERT_NEAR(shared::gtaoSlice(static_cast<float>(low), static_cast<float>(high), static_cast<float>(n)), sum, 3e-3)
            << n << " " << low << " " << high;
      }
}

TEST(GtaoFormulas, AnOpenSliceIsCutByNothing) {
  for (float n = -1.5f; n <= 1.5f; n += 0.1f) EXPECT_NEAR(shared::gtaoSlice(4.0f, 4.0f, n), shared::gtaoOpenSlice(n), 1e-5f);
}

TEST(GtaoFormulas, OccludersFadeTowardsTheRadius) {
  EXPECT_EQ(shared::gtaoWeight(0.0f, 2.0f), 1.0f);
  EXPECT_EQ(shared::gtaoWeight(1.1f, 2.0f), 1.0f);
  EXPECT_EQ(shared::gtaoWeight(2.0f, 2.0f), 0.0f);
  EXPECT_NEAR(shared::gtaoWeight(1.6f, 2.0f), 0.5f, 1e-5f);
}

TEST(GtaoFormulas, HorizonsRiseAtOnceAndFallByTheThickness) {
  EXPECT_EQ(shared::gtaoHorizon(0.2f, 0.7f, 0.1f), 0.7f);
  EXPECT_NEAR(shared::gtaoHorizon(0.7f, 0.2f, 0.1f), 0.65f, 1e-6f);
  EXPECT_EQ(shared::gtaoRise(-0.5f), 0.0f);
  EXPECT_EQ(shared::gtaoRise(0.5f), 1.0f);
}

TEST(GtaoFormulas, AngleOfTheNormalTurnsTowardsTheSlice) {
  const glm::vec3 along(1, 0, 0), viewer(0, 1, 0);
  EXPECT_NEAR(shared::gtaoNormalAngle({0.5f, 0.5f, 0}, along, viewer), 0.25f * static_cast<float>(kPi), 1e-6f);
  EXPECT_NEAR(shared::gtaoNormalAngle({-2, 0, 0}, along, viewer), -0.5f * static_cast<float>(kPi), 1e-6f);
}

/// What a ray from the eye meets: the point and the normal there.
struct Seen {
  glm::dvec3 point{0.0};
  glm::dvec3 normal{0.0};
};
using Scene3 = std::function<std::optional<Seen>(const glm::dvec3& from, const glm::dvec3& way)>;

/// Ground at y = 0, and one or two walls of `height` with their faces at x = -kFace (and kFace), as far as one can see; looked at from
/// above.
constexpr double kFace = 0.4;
struct Walls {
  double height = 0.0;
  bool both = false;

  std::optional<Seen> operator()(const glm::dvec3& from, const glm::dvec3& way) const {
    if (way.y >= 0.0) return std::nullopt;
    const auto top = from + way * ((from.y - height) / -way.y);
    if (height > 0.0 && (top.x < -kFace || (both && top.x > kFace))) return Seen{top, {0, 1, 0}};
    const auto ground = from + way * (from.y / -way.y);
    if (height > 0.0 && ground.x < -kFace) return Seen{from + way * ((from.x + kFace) / -way.x), {1, 0, 0}};
    if (both && ground.x > kFace) return Seen{from + way * ((kFace - from.x) / way.x), {-1, 0, 0}};
    return Seen{ground, {0, 1, 0}};
  }
  /// Sky of a point of the ground: an endless wall's form factor is half of one minus the sine of its horizon's height.
  double sky(double x) const {
    const auto hidden = [&](double distance) { return 0.5 * (1.0 - distance / std::hypot(distance, height)); };
    return 1.0 - hidden(x + kFace) - (both ? hidden(kFace - x) : 0.0);
  }
};

/// A search that misses no edge and forgets no horizon: those of the player find their horizons between two samples, a little low.
constexpr GtaoSearch kFine{8, 200, 0.0f};

class Gtao : public test::DeviceTest {
 protected:
  static constexpr int kSide = 192;

  /// Visibility of a picture of `scene`; `at` receives the points of its pixels.
  std::vector<test::Pixel> render(const Scene3& scene, const View& view, const GtaoSearch& search, double radius, std::vector<Seen>& at) {
    const glm::dmat4 clip = clipFromRelative(view, 1.0);
    GeometryImages images = imagesOf(scene, clip, eye(view), at);
    GpuImage light = makeLightImage(device, images).value();
    const TechniqueSettings settings{Technique::gtao, 0.0f, search, radius};
    DenoisePass denoise = makeDenoisePass(device, images, light).value();
    Baseline baseline = makeBaseline(device, settings, {images, denoise.raw, GpuImage{}}).value();
    const ScreenView seen{clip, eye(view), glm::vec3(1.0f)};
    EXPECT_TRUE(runCommands(device, [&](VkCommandBuffer commands) {
                  recordBaseline(commands, baseline, GlobalGrid{}, seen);
                  recordDenoise(commands, denoise, seen);
                }).ok());
    std::vector<test::Pixel> pixels = test::readPixels(device, light);
    destroyBaseline(device, baseline);
    destroyDenoisePass(device, denoise);
    destroyImage(device, light);
    destroyGeometryImages(device, images);
    return pixels;
  }

  static View above(double x, double z) { return lookAt({x, 6.0, z}, {0.0, 0.0, 0.0}, {0, 0, -1}, 0.8); }

  /// Root mean square error over the ground in the middle of the picture, from where the walls go on until they no longer count.
  static double errorOf(const std::vector<test::Pixel>& pixels, const std::vector<Seen>& at, const Walls& walls) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t n = 0; n < pixels.size(); ++n) {
      if (at[n].point.y > 1e-6 || at[n].normal.y < 0.5 || std::abs(at[n].point.z) > 0.5 || at[n].point.x > 0.5) continue;
      const double off = pixels[n].sky - walls.sky(at[n].point.x);
      sum += off * off;
      ++count;
    }
    EXPECT_GT(count, 500);
    return std::sqrt(sum / count);
  }

 private:
  GeometryImages imagesOf(const Scene3& scene, const glm::dmat4& clip, const glm::dvec3& from, std::vector<Seen>& at) {
    const glm::dmat4 back = glm::inverse(clip);
    std::vector<float> depths;
    std::vector<std::uint64_t> normals;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const glm::dvec4 way = back * glm::dvec4(2.0 * (x + 0.5) / kSide - 1.0, 2.0 * (y + 0.5) / kSide - 1.0, 0.5, 1.0);
        const std::optional<Seen> seen = scene(from, glm::normalize(glm::dvec3(way) / way.w));
        at.push_back(seen.value_or(Seen{}));
        const glm::dvec4 place = clip * glm::dvec4(at.back().point - from, 1.0);
        depths.push_back(seen ? static_cast<float>(place.z / place.w) : 0.0f);
        normals.push_back(glm::packHalf4x16(glm::vec4(glm::vec3(at.back().normal), 1.0f)));
      }
    const std::vector<std::uint32_t> white(kSide * kSide, 0xffffffffu);
    GeometryImages images = makeGeometryImages(device, {kSide, kSide}).value();
    EXPECT_TRUE(uploadImage(device, images.depth, std::as_bytes(std::span(depths)), kComputeSample).ok());
    EXPECT_TRUE(uploadImage(device, images.normal, std::as_bytes(std::span(normals)), kComputeSample).ok());
    EXPECT_TRUE(uploadImage(device, images.colour, std::as_bytes(std::span(white)), kComputeSample).ok());
    return images;
  }
};

TEST_F(Gtao, OpenGroundSeesTheWholeSkyFromAnyAngle) {
  for (const View& view : {above(0.0, 0.0), above(9.0, 3.0), lookAt({14, 1.5, 0}, {0, 0, 0}, {0, 1, 0}, 0.5)})
    for (const NamedGtaoSearch& quality : kGtaoQualities) {
      std::vector<Seen> at;
      const std::vector<test::Pixel> pixels = render(Walls{}, view, quality.search, 1e3, at);
      for (std::size_t n = 0; n < pixels.size(); ++n) {
        const float open = at[n].normal.y > 0.5 ? 1.0f : shared::kNoSurface;
        ASSERT_NEAR(pixels[n].sky, open, 5e-3f) << quality.name << " " << n;
      }
    }
}

TEST_F(Gtao, FindsTheSkyBesideAWall) {
  for (const double height : {0.2, 0.6}) {
    const Walls walls{height, false};
    std::vector<Seen> at;
    const std::vector<test::Pixel> pixels = render(walls, above(0.3, 0.2), kFine, 1e3, at);
    EXPECT_LT(errorOf(pixels, at, walls), 0.02) << height;
  }
}

TEST_F(Gtao, QualitiesComeNearTheFineSearch) {
  const Walls walls{0.6, false};
  double last = 1.0;
  for (const NamedGtaoSearch& quality : kGtaoQualities) {
    std::vector<Seen> at;
    const double error = errorOf(render(walls, above(0.3, 0.2), quality.search, 1e3, at), at, walls);
    EXPECT_LT(error, 0.12) << quality.name;
    EXPECT_LT(error, last) << quality.name;
    last = error;
  }
  EXPECT_LT(last, 0.05);
}

TEST_F(Gtao, FindsTheSkyInASlot) {
  const Walls walls{0.5, true};
  std::vector<Seen> at;
  EXPECT_LT(errorOf(render(walls, above(0.0, 0.0), kFine, 1e3, at), at, walls), 0.03);
}

TEST_F(Gtao, ForgetsWhatLiesBeyondTheRadius) {
  std::vector<Seen> at;
  const std::vector<test::Pixel> pixels = render(Walls{2.0, false}, above(0.3, 0.2), kFine, 0.5, at);
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    if (at[n].point.y > 1e-6 || at[n].normal.y < 0.5 || at[n].point.x < 0.2) continue;
    ASSERT_NEAR(pixels[n].sky, 1.0f, 5e-3f);
  }
}

}  // namespace
}  // namespace overcast
