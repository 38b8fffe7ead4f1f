#include "runtime/passes/tonemap/tonemap_pass.h"

#include <cmath>
#include <cstring>
#include <set>

#include <glm/gtc/packing.hpp>

#include "formats/camera.h"
#include "runtime/passes/shade/shade.h"
#include "tests/runtime/support.h"

namespace overcast::test {
namespace {

using glm::vec3;

TEST(Tonemap, EncodesAsTheStandardSays) {
  // IEC 61966-2-1: the two branches meet, and code 128 of 255 is a linear 0.2158605.
  EXPECT_NEAR(shared::encodeSrgb(0.2158605f), 128.0f / 255.0f, 1e-6f);
  EXPECT_EQ(shared::encodeSrgb(0.0f), 0.0f);
  EXPECT_NEAR(shared::encodeSrgb(1.0f), 1.0f, 1e-6f);
  EXPECT_NEAR(shared::encodeSrgb(0.0031307f), shared::encodeSrgb(0.0031309f), 1e-5f);
}

TEST(Tonemap, CurveRisesFromBlackToWhite) {
  EXPECT_EQ(shared::toneCurve(vec3(0.0f)), vec3(0.0f));
  EXPECT_EQ(shared::toneCurve(vec3(50.0f)), vec3(1.0f));
  float before = -1.0f;
  for (float x = 0.0f; x < 4.0f; x += 0.01f) {
    const float y = shared::toneCurve(vec3(x)).x;
    EXPECT_GT(y, before);
    before = y;
  }
  EXPECT_NEAR(shared::toneCurve(vec3(0.18f)).x, 0.267f, 0.001f);
  EXPECT_NEAR(shared::toneCurve(vec3(0.8f)).x, 0.752f, 0.001f);
}

TEST(Tonemap, DitherSpreadsItsThresholdsAndKeepsTheMean) {
  std::set<float> seen;
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) seen.insert(shared::ditherThreshold(x, y));
  EXPECT_EQ(seen.size(), 64u);
  EXPECT_FLOAT_EQ(*seen.begin(), 0.5f / 64.0f);
  EXPECT_FLOAT_EQ(*seen.rbegin(), 63.5f / 64.0f);
  for (const float value : {0.0f, 0.1234f, 0.5f, 0.99f, 1.0f}) {
    double sum = 0.0;
    for (const float threshold : seen) sum += static_cast<double>(shared::quantise(value, threshold)) * 255.0;
    EXPECT_NEAR(sum / 64.0, static_cast<double>(value) * 255.0, 0.5 / 64.0 + 1e-4);
  }
  // Neighbours differ much: the 2 x 2 block of an ordered dither holds one threshold of each quarter.
  for (int block = 0; block < 16; ++block) {
    std::set<int> quarters;
    for (int i = 0; i < 4; ++i)
      quarters.insert(static_cast<int>(4.0f * shared::ditherThreshold(2 * (block % 4) + i % 2, 2 * (block / 4) + i / 2)));
    EXPECT_EQ(quarters.size(), 4u);
  }
}

TEST(Tonemap, RaysOfThePictureAreThoseOfTheView) {
  const View view = lookAt({1, 2, 3}, {0, 0.5, 0}, {0, 1, 0}, 0.8);
  TonemapView seen;
  seen.relativeFromClip = glm::mat4(glm::inverse(clipFromRelative(view, 2.0)));
  const shared::TonemapPush constants = tonemapPush(seen, 200, 100, 1);
  const vec3 middle(constants.cornerRay + 0.5f * constants.rightRay + 0.5f * constants.downRay);
  EXPECT_LT(glm::length(glm::normalize(middle) - glm::normalize(vec3(-1.0f, -1.5f, -3.0f))), 1e-5f);
  EXPECT_GT(glm::dot(vec3(constants.rightRay), vec3(view.worldFromView[0])), 0.0f);
  EXPECT_LT(constants.downRay.y, 0.0f);
}

class TonemapOnDevice : public DeviceTest {};

TEST_F(TonemapOnDevice, EqualsTheFormulasInDouble) {
  constexpr int kWide = 20, kHigh = 13, kSide = 2;
  constexpr int kFullWide = kWide * kSide, kFullHigh = kHigh * kSide;
  std::vector<std::uint64_t> texels;
  std::vector<glm::vec4> values;
  for (int i = 0; i < kFullWide * kFullHigh; ++i) {
    const glm::vec4 value(0.001f * static_cast<float>((i * 37) % 1500), 0.01f * static_cast<float>(i % 97), 0.25f,
                          i % 5 == 0 ? shared::kNoSurface : 0.01f * static_cast<float>(i % 101));
    texels.push_back(glm::packHalf4x16(value));
    values.push_back(glm::unpackHalf4x16(texels.back()));
  }
  ImageSettings settings;
  settings.extent = {kFullWide, kFullHigh, 1};
  settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
  settings.format = VK_FORMAT_R16G16B16A16_SFLOAT;
  GpuImage light = makeImage(device, settings).value();
  ASSERT_TRUE(uploadImage(device, light, std::as_bytes(std::span(texels)), kShaderSample).ok());
  Result<TonemapPass> pass = makeTonemapPass(device, light, kSide);
  ASSERT_TRUE(pass.ok()) << message(pass.error());
  TonemapView seen;
  const View view = lookAt({1, 2, 3}, {0, 0.5, 0}, {0, 1, 0}, 0.8);
  seen.relativeFromClip = glm::mat4(glm::inverse(clipFromRelative(view, double(kWide) / kHigh)));
  seen.skyColour = {0.7f, 0.9f, 1.1f};
  seen.exposure = 1.3f;
  ASSERT_TRUE(runCommands(device, [&](VkCommandBuffer commands) { recordTonemap(commands, pass.value(), seen); }).ok());
  const auto linear = readImage(device, pass.value().resolved, kTransferRead).value();
  const auto display = readImage(device, pass.value().display, kTransferRead).value();

  const shared::TonemapPush constants = tonemapPush(seen, kWide, kHigh, kSide);
  for (int i = 0; i < kWide * kHigh; ++i) {
    glm::dvec4 mean(0.0);
    for (int s = 0; s < kSide * kSide; ++s) {
      const int x = (i % kWide) * kSide + s % kSide, y = (i / kWide) * kSide + s / kSide;
      const auto full = static_cast<std::size_t>(y * kFullWide + x);
      const glm::dvec3 ray = glm::dvec3(constants.cornerRay) + (x + 0.5) / kFullWide * glm::dvec3(constants.rightRay) +
                             (y + 0.5) / kFullHigh * glm::dvec3(constants.downRay);
      const vec3 behind = shared::backdrop(seen.skyColour, static_cast<float>(glm::normalize(ray).y));
      mean += 0.25 * (full % 5 != 0 ? glm::dvec4(values[full]) : glm::dvec4(behind, 1.0));
    }
    glm::vec4 got;
    std::memcpy(&got, linear.data() + 16 * static_cast<std::size_t>(i), 16);
    for (int c = 0; c < 4; ++c) ASSERT_NEAR(got[c], mean[c], 1e-5) << i;
    const vec3 shown = shared::toneCurve(vec3(mean) * 1.3f);
    for (int c = 0; c < 3; ++c) {
      const float exact = 255.0f * shared::encodeSrgb(shown[c]) + shared::ditherThreshold(i % kWide, i / kWide);
      const auto code = static_cast<float>(std::to_integer<int>(display[4 * static_cast<std::size_t>(i) + static_cast<std::size_t>(c)]));
      ASSERT_TRUE(code >= std::floor(exact - 2e-3f) && code <= std::floor(exact + 2e-3f)) << i << ": " << code << " of " << exact;
    }
  }
  destroyTonemapPass(device, pass.value());
  destroyImage(device, light);
}

}  // namespace
}  // namespace overcast::test
