// Frames: a fixture that renders pictures of a scene file.
#pragma once

#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include "runtime/frame.h"
#include "tests/runtime/support.h"

namespace overcast::test {

/// Opens a scene and a renderer for it, and closes both.
class Frames : public DeviceTest {
 protected:
  /// `sky` in place of the scene's own.
  void open(const std::filesystem::path& file, const FrameSettings& wanted, const std::optional<SkyHarmonics>& sky = {}) {
    Result<RuntimeScene> loaded = loadScene(device, file);
    ASSERT_TRUE(loaded.ok()) << message(loaded.error());
    scene = std::move(loaded).value();
    if (sky) scene.sky = sky;
    Result<FrameRenderer> made = makeFrameRenderer(device, scene, wanted);
    ASSERT_TRUE(made.ok()) << message(made.error());
    renderer = std::move(made).value();
  }
  void close() {
    destroyFrameRenderer(device, renderer);
    destroyScene(device, scene);
  }
  void TearDown() override {
    close();
    DeviceTest::TearDown();
  }
  View viewAt(double time) const {
    return defaultView(scene, time, static_cast<double>(renderer.settings.width) / renderer.settings.height);
  }
  std::vector<PassTime> render(double time) {
    Result<std::vector<PassTime>> times = renderFrame(device, renderer, scene, time, viewAt(time));
    EXPECT_TRUE(times.ok());
    return times.ok() ? std::move(times).value() : std::vector<PassTime>(5);
  }
  Image linear() { return readLinear(device, renderer).value(); }
  Image display() { return readDisplay(device, renderer).value(); }

  RuntimeScene scene;
  FrameRenderer renderer;
  FrameSettings settings{160, 90, 1, {}, {}};
};

/// Pixel of a world-space point.
inline glm::ivec2 pixelOf(const FrameRenderer& renderer, const View& view, const glm::dvec3& point) {
  const FrameSettings& s = renderer.settings;
  const glm::dvec4 clip = clipFromRelative(view, static_cast<double>(s.width) / s.height) * glm::dvec4(point - eye(view), 1.0);
  return {static_cast<int>((clip.x / clip.w * 0.5 + 0.5) * s.width), static_cast<int>((clip.y / clip.w * 0.5 + 0.5) * s.height)};
}

}  // namespace overcast::test
