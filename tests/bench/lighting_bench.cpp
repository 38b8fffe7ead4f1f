// Bench of lighting through apertures: the error of every mode against rays, beside the time of its pass, while the lights move.
//   overcast-bench-lighting SCENE.gltf... [--width W --height H] [--times N] [--runs N] [--json] [--device NAME]
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "formats/console.h"
#include "runtime/frame.h"
#include "tests/bench/ray_traced.h"

namespace {

using namespace overcast;
using bench::RayTracedPixel;
using Json = nlohmann::ordered_json;

struct Options {
  std::vector<std::string> scenes;
  std::string device;
  int times = 4;
  int runs = 9;
  bool json = false;
  bench::RayTracedSettings rays;
};

struct Mode {
  const char* name;
  ApertureMode mode;
};
constexpr std::array kModes{Mode{"smoothstep", ApertureMode::smoothstep}, Mode{"fast", ApertureMode::fast},
                            Mode{"exact", ApertureMode::exact}, Mode{"accurate", ApertureMode::accurate}};

/// Sums over surfaces, colours and moments in time.
struct Squares {
  double sum = 0.0;
  double count = 0.0;
  void add(const glm::dvec3& error) {
    sum += glm::dot(error, error);
    count += 3.0;
  }
  double root() const { return std::sqrt(sum / std::max(count, 1.0)); }
};

struct Spread {
  double median = 0.0;
  double low = 0.0;  ///< lower quartile
  double high = 0.0;
};

Spread spreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto quantile = [&](double q) { return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)]; };
  return {quantile(0.5), quantile(0.25), quantile(0.75)};
}

struct ModeRow {
  Squares all;
  Squares lights;
  std::vector<double> milliseconds;  ///< of the aperture pass; [i] of all modes were taken one after the other
};

struct SceneRows {
  std::array<ModeRow, kModes.size()> modes;
  Squares spread, lightSpread;  ///< of the truth about its own mean: what a picture of one colour would err
  glm::dvec3 mean{0.0}, lit{0.0};
  double surfaces = 0.0;
};

struct Opened {
  RuntimeScene scene;
  std::array<FrameRenderer, kModes.size()> renderers;
};

glm::dvec3 truthOf(const RayTracedPixel& pixel, bool withSky) {
  return glm::dvec3(pixel.lights) + (withSky ? glm::dvec3(pixel.sky) : glm::dvec3(0.0));
}

/// One frame of one mode: its error into `squares`, its time into `times`.
Result<Done> frameOf(const Device& device, Opened& opened, std::size_t mode, double time, const View& view,
                     const std::vector<RayTracedPixel>& truth, bool withSky, Squares& squares, std::vector<double>* times) {
  FrameRenderer& renderer = opened.renderers[mode];
  const Result<std::vector<PassTime>> passes = renderFrame(device, renderer, opened.scene, time, view);
  if (!passes) return passes.error();
  for (const PassTime& pass : passes.value())
    if (times && pass.name == "aperture") times->push_back(pass.milliseconds);
  const Result<Image> image = readLinear(device, renderer);
  if (!image) return image.error();
  const std::vector<float>& pixels = image.value().pixels;
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (truth[i].surface) squares.add(glm::dvec3(pixels[4 * i], pixels[4 * i + 1], pixels[4 * i + 2]) - truthOf(truth[i], withSky));
  return Done{};
}

/// What the truth itself is, for the share of it that an error is.
void addTruth(const std::vector<RayTracedPixel>& truth, SceneRows& rows) {
  glm::dvec3 all(0.0), lit(0.0);
  double count = 0.0;
  for (const RayTracedPixel& pixel : truth) {
    if (!pixel.surface) continue;
    all += truthOf(pixel, true);
    lit += truthOf(pixel, false);
    count += 1.0;
  }
  rows.mean += all;
  rows.lit += lit;
  rows.surfaces += count;
  for (const RayTracedPixel& pixel : truth) {
    if (!pixel.surface) continue;
    rows.spread.add(truthOf(pixel, true) - all / count);
    rows.lightSpread.add(truthOf(pixel, false) - lit / count);
  }
}

/// All modes at one moment: modes take turns, so that what else the machine does meets all of them.
Result<Done> measureAt(const Device& device, Opened& opened, const Scene& source, double time, const Options& options, SceneRows& rows) {
  const View view = defaultView(opened.scene, time, static_cast<double>(options.rays.width) / options.rays.height);
  const SkyHarmonics sky = opened.scene.sky.value_or(uniformSky(opened.scene.lighting.skyColour));
  const std::vector<RayTracedPixel> truth = bench::rayTrace(source, opened.scene.lighting, sky, time, view, options.rays);
  addTruth(truth, rows);
  Result<Done> done = Done{};
  for (int run = 0; run <= options.runs && done; ++run) {
    // The first run is not timed: it makes caches warm.
    for (std::size_t m = 0; m < kModes.size() && done; ++m) {
      Squares again;
      done = frameOf(device, opened, m, time, view, truth, true, run == 0 ? rows.modes[m].all : again,
                     run == 0 ? nullptr : &rows.modes[m].milliseconds);
    }
  }
  const glm::vec3 colour = opened.scene.lighting.skyColour;
  const std::optional<SkyHarmonics> image = opened.scene.sky;
  opened.scene.lighting.skyColour = glm::vec3(0.0f);
  if (image) opened.scene.sky = SkyHarmonics{};
  for (std::size_t m = 0; m < kModes.size() && done; ++m)
    done = frameOf(device, opened, m, time, view, truth, false, rows.modes[m].lights, nullptr);
  opened.scene.lighting.skyColour = colour;
  opened.scene.sky = image;
  return done;
}

Result<SceneRows> measure(const Device& device, Opened& opened, const Scene& source, const Options& options) {
  for (std::size_t m = 0; m < kModes.size(); ++m) {
    Result<FrameRenderer> renderer =
        makeFrameRenderer(device, opened.scene, {options.rays.width, options.rays.height, 1, {}, {}, kModes[m].mode, {}});
    if (!renderer) return renderer.error();
    opened.renderers[m] = std::move(renderer).value();
  }
  SceneRows rows;
  const double duration = animationDuration(source);
  const int times = duration > 0.0 ? options.times : 1;
  for (int i = 0; i < times; ++i) {
    const Result<Done> done = measureAt(device, opened, source, duration * i / times, options, rows);
    if (!done) return done.error();
  }
  rows.mean /= std::max(rows.surfaces, 1.0);
  rows.lit /= std::max(rows.surfaces, 1.0);
  return rows;
}

/// Time of a mode over that of the published one, run by run.
Spread overPublished(const SceneRows& rows, std::size_t mode) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < rows.modes[mode].milliseconds.size(); ++i)
    ratios.push_back(rows.modes[mode].milliseconds[i] / rows.modes[0].milliseconds[i]);
  return spreadOf(std::move(ratios));
}

double meanOf(const glm::dvec3& colour) {
  return (colour.x + colour.y + colour.z) / 3.0;
}

std::string table(const std::string& name, const SceneRows& rows) {
  std::string text = fmt::format("{}: mean radiance {:.4f}, {:.4f} of it by lights\n", name, meanOf(rows.mean), meanOf(rows.lit));
  text += fmt::format("{:<12} {:>10} {:>13} {:>22} {:>26}\n", "mode", "all light", "lights alone", "pass ms", "times the published");
  text += fmt::format("{:<12} {:>10.4f} {:>13.4f}\n", "their mean", rows.spread.root(), rows.lightSpread.root());
  for (std::size_t m = 0; m < kModes.size(); ++m) {
    const Spread ms = spreadOf(rows.modes[m].milliseconds), ratio = overPublished(rows, m);
    text += fmt::format("{:<12} {:>10.4f} {:>13.4f} {:>22} {:>26}\n", kModes[m].name, rows.modes[m].all.root(), rows.modes[m].lights.root(),
                        fmt::format("{:.3f} ({:.3f}-{:.3f})", ms.median, ms.low, ms.high),
                        fmt::format("{:.2f} ({:.2f}-{:.2f})", ratio.median, ratio.low, ratio.high));
  }
  return text;
}

Json json(const std::string& name, const SceneRows& rows) {
  const auto spread = [](const Spread& s) { return Json{{"median", s.median}, {"lowerQuartile", s.low}, {"upperQuartile", s.high}}; };
  Json modes = Json::array();
  for (std::size_t m = 0; m < kModes.size(); ++m)
    modes.push_back({{"mode", kModes[m].name},
                     {"rmse", rows.modes[m].all.root()},
                     {"rmseLights", rows.modes[m].lights.root()},
                     {"milliseconds", spread(spreadOf(rows.modes[m].milliseconds))},
                     {"timesPublished", spread(overPublished(rows, m))}});
  return {{"scene", name},
          {"mean", meanOf(rows.mean)},
          {"meanLights", meanOf(rows.lit)},
          {"deviation", rows.spread.root()},
          {"deviationLights", rows.lightSpread.root()},
          {"modes", modes}};
}

Result<SceneRows> measureScene(const Device& device, const std::string& file, const Options& options) {
  const Result<Scene> source = readScene(file);
  if (!source) return source.error();
  Result<RuntimeScene> scene = loadScene(device, file);
  if (!scene) return scene.error();
  Opened opened{std::move(scene).value(), {}};
  Result<SceneRows> rows = Error{file, "", "no mesh of it has apertures: bake it with --apertures vertex"};
  if (hasApertures(opened.scene)) rows = measure(device, opened, source.value(), options);
  for (FrameRenderer& renderer : opened.renderers) destroyFrameRenderer(device, renderer);
  destroyScene(device, opened.scene);
  return rows;
}

Result<Done> run(const Options& options) {
  Result<Device> device = openDevice({options.device, false, {}, false});
  if (!device) return device.error();
  Json all = {{"device", device.value().info.name}, {"scenes", Json::array()}};
  if (!options.json)
    printResult(
        fmt::format("{}; {}x{}, {} rays for each light, {} for the sky; {} moments, {} runs each\n"
                    "linear radiance, root of the mean square error; medians (and quartiles)\n",
                    device.value().info.name, options.rays.width, options.rays.height, options.rays.lightRays, options.rays.skyRays,
                    options.times, options.runs));
  Result<Done> done = Done{};
  for (const std::string& file : options.scenes) {
    const Result<SceneRows> rows = measureScene(device.value(), file, options);
    if (!rows) {
      done = rows.error();
      break;
    }
    const std::string name = std::filesystem::path(file).stem().string();
    if (options.json)
      all["scenes"].push_back(json(name, rows.value()));
    else
      printResult("\n" + table(name, rows.value()));
  }
  closeDevice(device.value());
  if (done && options.json) printResult(all.dump(2) + "\n");
  return done;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Error of lighting through apertures against rays, beside its time"};
  Options options;
  app.add_option("SCENE", options.scenes, "baked scenes with apertures (.gltf)")->required();
  app.add_option("--width", options.rays.width)->check(CLI::Range(8, 4096))->capture_default_str();
  app.add_option("--height", options.rays.height)->check(CLI::Range(8, 4096))->capture_default_str();
  app.add_option("--light-rays", options.rays.lightRays, "for each light and pixel")->check(CLI::Range(1, 65536))->capture_default_str();
  app.add_option("--sky-rays", options.rays.skyRays, "for each pixel")->check(CLI::Range(1, 65536))->capture_default_str();
  app.add_option("--times", options.times, "moments of the animation, evenly")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--runs", options.runs, "timed frames of each mode and moment")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_flag("--json", options.json, "the result as JSON");
  app.add_option("--device", options.device, "index or part of the name of the Vulkan device (default: the best GPU, else the CPU)");
  CLI11_PARSE(app, argc, argv);
  const Result<Done> done = run(options);
  if (done && flushResults()) return 0;
  printMessage(fmt::format("overcast-bench-lighting: {}\n", done ? "cannot write the result" : message(done.error())));
  return 1;
}
