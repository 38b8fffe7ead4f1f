// ShadedGround: what the shade pass makes of a ground and a field that tests know in closed form.
#pragma once

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/passes/denoise/denoise_pass.h"
#include "runtime/passes/shade/shade_pass.h"
#include "tests/reference/sky.h"
#include "tests/runtime/ground.h"
#include "tests/runtime/scenes.h"
#include "tests/runtime/support.h"

namespace overcast::test {

inline Estimator named(const char* name) {
  Estimator estimator;
  estimator.name = name;
  return estimator;
}

/// Light of a ground of geometry images under an exact field.
class ShadedGround : public DeviceTest {
 protected:
  struct Setting : GroundView {
    glm::vec3 skyColour{0.5f, 0.25f, 1.0f};
    Estimator estimator = named("published");
  };

  /// Shades `ground` in `field` with 64 x 64 pixels.
  std::vector<Pixel> shade(const reference::Field& field, const Ground& ground, const Setting& setting) {
    GpuImage volume = uploadField(device, field);
    const SkyEstimator estimator = skyEstimator(setting.estimator, kGroundSide).value();
    PyramidPass pyramid = makePyramidPass(device, volume, estimator.levels).value();
    GeometryImages images = uploadGround(device, ground, setting);
    GpuImage light = makeLightImage(device, images).value();
    DenoisePass denoise =
        makeDenoisePass(device, images, light, {.wide = true, .few = !estimator.steps.empty(), .rays = std::max(estimator.traced, 1)})
            .value();
    ShadePass pass = makeShadePass(device, images, takesTurns(estimator) ? denoise.raw : light, pyramid, estimator).value();
    const ShadeView view{clipFromRelative(setting), setting.eye, setting.skyColour, glm::vec3(0, 1, 0)};
    const Result<Done> done = runCommands(device, [&](VkCommandBuffer commands) {
      recordPyramid(commands, pyramid);
      recordShade(commands, pass, setting.grid, view);
      if (takesTurns(estimator)) recordDenoise(commands, denoise, {view.clipFromRelative, view.eye, view.skyColour});
    });
    EXPECT_TRUE(done.ok());
    std::vector<Pixel> pixels = readPixels(device, light);
    destroyShadePass(device, pass);
    destroyDenoisePass(device, denoise);
    destroyImage(device, light);
    destroyGeometryImages(device, images);
    destroyPyramidPass(device, pyramid);
    destroyImage(device, volume);
    return pixels;
  }
};

}  // namespace overcast::test
