// Bench of the sky estimators: the error of each against rays, beside the time of the passes it needs.
//   overcast-bench-sky SCENE.gltf... [--taps N] [--width PIXELS] [--height PIXELS] [--device NAME]
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "formats/console.h"
#include "runtime/frame.h"
#include "tests/bench/ray_traced.h"

namespace {

using namespace overcast;
using bench::RayTracedPixel;

constexpr int kRuns = 5;
constexpr std::array<std::string_view, 4> kPasses{"pyramid", "shade", "denoise", "aperture"};  // that light the picture

struct Options {
  std::vector<std::string> scenes;
  std::string device;
  std::optional<int> taps;
  double time = 0.0;
  bench::RayTracedSettings rays;
};

struct Row {
  double rmse = 0.0;
  double bias = 0.0;
  double milliseconds = 0.0;  ///< of kPasses
};

Result<double> timeOfFrame(const Device& device, FrameRenderer& renderer, const RuntimeScene& scene, const Options& options,
                           const View& view) {
  const Result<std::vector<PassTime>> passes = renderFrame(device, renderer, scene, options.time, view);
  if (!passes) return passes.error();
  double sum = 0.0;
  for (const PassTime& pass : passes.value())
    if (std::find(kPasses.begin(), kPasses.end(), pass.name) != kPasses.end()) sum += pass.milliseconds;
  return sum;
}

/// A fresh renderer each time: the pyramid is skipped where nothing moves.
Result<Row> measure(const Device& device, const RuntimeScene& scene, const Options& options, const View& view, const char* name,
                    const std::vector<RayTracedPixel>& truth) {
  FrameSettings settings{options.rays.width, options.rays.height, 1, {}, options.taps};
  settings.estimator = name;
  std::vector<double> times;
  Row row;
  for (int run = 0; run < kRuns; ++run) {
    Result<FrameRenderer> renderer = makeFrameRenderer(device, scene, settings);
    if (!renderer) return renderer.error();
    const Result<double> time = timeOfFrame(device, renderer.value(), scene, options, view);
    const Result<Image> image = time ? readLinear(device, renderer.value()) : time.error();
    destroyFrameRenderer(device, renderer.value());
    if (!image) return image.error();
    times.push_back(time.value());
    double squares = 0.0, sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double visible = image.value().pixels[4 * i + 3];
      if (!truth[i].surface || visible < 0.0) continue;
      squares += (visible - truth[i].visible) * (visible - truth[i].visible);
      sum += visible - truth[i].visible;
      count += 1.0;
    }
    row = {std::sqrt(squares / std::max(count, 1.0)), sum / std::max(count, 1.0), 0.0};
  }
  std::sort(times.begin(), times.end());
  row.milliseconds = times[times.size() / 2];
  return row;
}

Result<Done> printTable(const Device& device, const std::string& file, const Options& options) {
  Result<Scene> source = readScene(file);
  if (!source) return source.error();
  Result<RuntimeScene> loaded = loadScene(device, file);
  if (!loaded) return loaded.error();
  RuntimeScene& scene = loaded.value();
  scene.lighting.sun.reset();
  scene.lighting.areaLights.clear();
  const View view = defaultView(scene, options.time, static_cast<double>(options.rays.width) / options.rays.height);
  const std::vector<RayTracedPixel> truth =
      bench::rayTrace(source.value(), scene.lighting, uniformSky(scene.lighting.skyColour), options.time, view, options.rays);
  double mean = 0.0, squares = 0.0, count = 0.0;
  for (const RayTracedPixel& pixel : truth)
    if (pixel.surface) mean += pixel.visible, squares += pixel.visible * pixel.visible, count += 1.0;
  mean /= std::max(count, 1.0);
  fmt::print("{}{}\n", file, hasApertures(scene) ? " (apertures)" : "");
  fmt::print("  {:<15} {:>8} {:>8} {:>10}\n", "estimator", "rmse", "bias", "ms");
  fmt::print("  {:<15} {:>8.4f}\n", "their mean", std::sqrt(std::max(squares / std::max(count, 1.0) - mean * mean, 0.0)));
  Result<Done> done = Done{};
  for (const char* name : kEstimators) {
    const Result<Row> row = measure(device, scene, options, view, name, truth);
    if (!row) {
      done = row.error();
      break;
    }
    fmt::print("  {:<15} {:>8.4f} {:>8.4f} {:>10.2f}\n", name, row.value().rmse, row.value().bias, row.value().milliseconds);
  }
  destroyScene(device, scene);
  return done;
}

Result<Done> run(const Options& options) {
  Result<Device> device = openDevice({options.device, false, {}, false});
  if (!device) return device.error();
  Result<Done> done = Done{};
  for (const std::string& scene : options.scenes) {
    done = printTable(device.value(), scene, options);
    if (!done) break;
  }
  fmt::print("{} rays per pixel; {}\n", options.rays.skyRays, device.value().info.name);
  closeDevice(device.value());
  return done;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Error of the sky estimators against rays, beside their time"};
  Options options;
  int taps = 0;
  app.add_option("SCENE", options.scenes, "baked scenes (.gltf)")->required();
  auto* tapsOption = app.add_option("--taps", taps, "of every estimator (default: the scene's)")->check(CLI::Range(1, 8));
  app.add_option("--width", options.rays.width)->check(CLI::Range(8, 4096))->capture_default_str();
  app.add_option("--height", options.rays.height)->check(CLI::Range(8, 4096))->capture_default_str();
  app.add_option("--sky-rays", options.rays.skyRays, "for each pixel")->check(CLI::Range(1, 65536))->capture_default_str();
  app.add_option("--time", options.time, "seconds of the animation")->capture_default_str();
  app.add_option("--device", options.device, "index or part of the name of the Vulkan device (default: the best GPU, else the CPU)");
  CLI11_PARSE(app, argc, argv);
  if (tapsOption->count() > 0) options.taps = taps;
  const Result<Done> done = run(options);
  if (done) return 0;
  printMessage(fmt::format("overcast-bench-sky: {}\n", message(done.error())));
  return 1;
}
