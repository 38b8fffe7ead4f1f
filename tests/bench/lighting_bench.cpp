// Bench of lighting through apertures: the error of every mode against rays, beside the time of its pass.
//   overcast-bench-lighting SCENE.gltf [--size WxH] [--time SECONDS] [--device NAME]
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
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

struct Options {
  std::string scene;
  std::string device;
  double time = 0.0;
  bench::RayTracedSettings rays;
};

struct Mode {
  const char* name;
  ApertureMode mode;
};
constexpr std::array kModes{Mode{"smoothstep", ApertureMode::smoothstep}, Mode{"fast", ApertureMode::fast},
                            Mode{"exact", ApertureMode::exact}, Mode{"accurate", ApertureMode::accurate}};

glm::dvec3 truthOf(const RayTracedPixel& pixel, bool withSky) {
  return glm::dvec3(pixel.lights) + (withSky ? glm::dvec3(pixel.sky) : glm::dvec3(0.0));
}

/// Root of the mean square over surfaces and colours of what `value` gives less the truth.
template <class Value>
double rmse(const std::vector<RayTracedPixel>& truth, bool withSky, const Value& value) {
  double squares = 0.0, count = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!truth[i].surface) continue;
    const glm::dvec3 error = value(i) - truthOf(truth[i], withSky);
    squares += glm::dot(error, error);
    count += 3.0;
  }
  return std::sqrt(squares / std::max(count, 1.0));
}

glm::dvec3 meanOf(const std::vector<RayTracedPixel>& truth, bool withSky) {
  glm::dvec3 sum(0.0);
  double count = 0.0;
  for (const RayTracedPixel& pixel : truth) {
    if (!pixel.surface) continue;
    sum += truthOf(pixel, withSky);
    count += 1.0;
  }
  return sum / std::max(count, 1.0);
}

struct Row {
  double all = 0.0;
  double lights = 0.0;
  double milliseconds = 0.0;
};

Result<double> errorOfFrame(const Device& device, FrameRenderer& renderer, const RuntimeScene& scene, const Options& options,
                            const View& view, const std::vector<RayTracedPixel>& truth, bool withSky, std::vector<double>& times) {
  const Result<std::vector<PassTime>> passes = renderFrame(device, renderer, scene, options.time, view);
  if (!passes) return passes.error();
  times.push_back(passes.value()[static_cast<std::size_t>(FramePass::aperture)].milliseconds);
  const Result<Image> image = readLinear(device, renderer);
  if (!image) return image.error();
  const std::vector<float>& pixels = image.value().pixels;
  return rmse(truth, withSky, [&](std::size_t i) { return glm::dvec3(pixels[4 * i], pixels[4 * i + 1], pixels[4 * i + 2]); });
}

Result<Row> measure(const Device& device, RuntimeScene& scene, const Options& options, const View& view, ApertureMode mode,
                    const std::vector<RayTracedPixel>& truth) {
  Result<FrameRenderer> renderer = makeFrameRenderer(device, scene, {options.rays.width, options.rays.height, 1, {}, {}, mode, {}});
  if (!renderer) return renderer.error();
  const glm::vec3 sky = scene.lighting.skyColour;
  std::vector<double> times;
  Result<double> all = 0.0, lights = 0.0;
  for (int run = 0; run < kRuns && all; ++run) all = errorOfFrame(device, renderer.value(), scene, options, view, truth, true, times);
  scene.lighting.skyColour = glm::vec3(0.0f);
  if (all) lights = errorOfFrame(device, renderer.value(), scene, options, view, truth, false, times);
  scene.lighting.skyColour = sky;
  destroyFrameRenderer(device, renderer.value());
  if (!all) return all.error();
  if (!lights) return lights.error();
  std::sort(times.begin(), times.end());
  return Row{all.value(), lights.value(), times[times.size() / 2]};
}

Result<Done> printTable(const Device& device, RuntimeScene& scene, const Scene& source, const Options& options) {
  if (!hasApertures(scene)) return Error{options.scene, "", "no mesh of it has apertures"};
  const View view = defaultView(scene, options.time, static_cast<double>(options.rays.width) / options.rays.height);
  const std::vector<RayTracedPixel> truth = bench::rayTrace(source, scene.lighting, options.time, view, options.rays);
  const auto surfaces = std::count_if(truth.begin(), truth.end(), [](const RayTracedPixel& pixel) { return pixel.surface; });
  const glm::dvec3 mean = meanOf(truth, true), lit = meanOf(truth, false);
  fmt::print("{}: {} pixels of {}x{}, {} rays for each light, {} for the sky; linear radiance, root of the mean square error\n",
             options.scene, surfaces, options.rays.width, options.rays.height, options.rays.lightRays, options.rays.skyRays);
  fmt::print("{:<12} {:>12} {:>12} {:>14}\n", "mode", "all light", "lights alone", "pass ms");
  fmt::print("{:<12} {:>12.4f} {:>12.4f} {:>14}\n", "their mean", rmse(truth, true, [&](std::size_t) { return mean; }),
             rmse(truth, false, [&](std::size_t) { return lit; }), "");
  for (const Mode& mode : kModes) {
    const Result<Row> row = measure(device, scene, options, view, mode.mode, truth);
    if (!row) return row.error();
    fmt::print("{:<12} {:>12.4f} {:>12.4f} {:>14.2f}\n", mode.name, row.value().all, row.value().lights, row.value().milliseconds);
  }
  fmt::print("mean radiance {:.4f}, {:.4f} of it by lights; {}\n", (mean.x + mean.y + mean.z) / 3.0, (lit.x + lit.y + lit.z) / 3.0,
             device.info.name);
  return Done{};
}

Result<Done> run(const Options& options) {
  const Result<Scene> source = readScene(options.scene);
  if (!source) return source.error();
  Result<Device> device = openDevice({options.device, false, {}, false});
  if (!device) return device.error();
  Result<RuntimeScene> scene = loadScene(device.value(), options.scene);
  Result<Done> result = scene ? printTable(device.value(), scene.value(), source.value(), options) : scene.error();
  if (scene) destroyScene(device.value(), scene.value());
  closeDevice(device.value());
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Error of lighting through apertures against rays, beside its time"};
  Options options;
  app.add_option("SCENE", options.scene, "a baked scene with apertures (.gltf)")->required();
  app.add_option("--width", options.rays.width)->check(CLI::Range(8, 4096))->capture_default_str();
  app.add_option("--height", options.rays.height)->check(CLI::Range(8, 4096))->capture_default_str();
  app.add_option("--light-rays", options.rays.lightRays, "for each light and pixel")->check(CLI::Range(1, 65536))->capture_default_str();
  app.add_option("--sky-rays", options.rays.skyRays, "for each pixel")->check(CLI::Range(1, 65536))->capture_default_str();
  app.add_option("--time", options.time, "seconds of the animation")->capture_default_str();
  app.add_option("--device", options.device, "index or part of the name of the Vulkan device (default: the best GPU, else the CPU)");
  CLI11_PARSE(app, argc, argv);
  const Result<Done> done = run(options);
  if (done) return 0;
  printMessage(fmt::format("overcast-bench-lighting: {}\n", message(done.error())));
  return 1;
}
