#include "runtime/player/options.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <regex>

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "formats/image.h"
#include "runtime/passes/shade/sky_estimator.h"
#include "runtime/player/command.h"

namespace overcast {
namespace {

/// Where the frame number goes: a run of # or a printf-like %d.
const std::regex& placeholder() {
  static const std::regex kPlaceholder("#+|%0?([1-9]?)d");
  return kPlaceholder;
}

/// Parses an option's text by `parse` into `into`; a usage error that says why.
template <class T, class Into>
void take(const std::string& option, const Result<T>& parsed, Into& into) {
  if (!parsed) throw CLI::ValidationError(option, message(parsed.error()));
  into = parsed.value();
}

/// What spans several options.
void check(const PlayerOptions& options) {
  if (options.listDevices) return;
  if (options.scene.empty()) throw CLI::RequiredError("SCENE");
  for (const std::string& output : options.outputs) {
    const std::string extension = std::filesystem::path(output).extension().string();
    if (extension != ".png" && extension != ".exr") throw CLI::ValidationError("-o", output + " ends neither in .png nor in .exr");
    if (options.firstFrame != options.lastFrame && !hasFrameNumber(output))
      throw CLI::ValidationError("-o", output + " has no place for the frame number (#### or %04d)");
  }
  const int most = kMaxImageSide / options.supersample;
  if (options.width > most || options.height > most)
    throw CLI::ValidationError("--size", fmt::format("with --supersample {} a side is at most {}", options.supersample, most));
  if (options.resolution && *options.resolution % 8 != 0) throw CLI::ValidationError("--resolution", "is not a multiple of 8");
  if (options.taps && options.estimator && !readsTaps(*options.estimator))
    throw CLI::ValidationError("--taps", *options.estimator + " reads none");
}

const std::map<std::string, ApertureMode> kApertureModes{{"exact", ApertureMode::exact},
                                                         {"smoothstep", ApertureMode::smoothstep},
                                                         {"fast", ApertureMode::fast},
                                                         {"accurate", ApertureMode::accurate}};

std::map<std::string, Technique> techniques() {
  std::map<std::string, Technique> names;
  for (const NamedTechnique& named : kTechniques) names.emplace(named.name, named.technique);
  return names;
}

std::vector<std::string> gtaoQualities() {
  std::vector<std::string> names;
  for (const NamedGtaoSearch& quality : kGtaoQualities) names.emplace_back(quality.name);
  return names;
}

std::string otherTechniques() {
  std::string names;
  for (const NamedTechnique& named : kTechniques)
    if (named.technique != Technique::overcast) names += (names.empty() ? "" : ", ") + std::string(named.name);
  return names;
}

constexpr const char* kFooter =
    "Exit codes: 0 done, 1 internal error (or validation messages), 2 usage, 3 unreadable scene, 4 cannot write, 5 no usable device.\n"
    "Without --camera the scene's own camera is taken, or one that shows the whole scene.\n"
    "overcast-player cost measures what occluders take in the composite of a device: see overcast-player cost --help.\n"
    "overcast-player calibrate fits a scene's estimator to its reference: see overcast-player calibrate --help.\n"
    "overcast-player measure compares pictures with references: see overcast-player measure --help.\n"
    "overcast-player report measures every setting on scenes, overcast-player compare two reports: see their --help.\n"
    "Without --headless a window opens: left mouse button turns, right pans, wheel zooms, space pauses, F12 saves a picture.";

/// Options as they are given, before they are parsed.
struct Given {
  std::string frames, size, camera;
  int resolution = 0, taps = 0;
  std::string estimator;
  Daylight day;
  double gtaoRadius = 0.0;
  std::string gtaoQuality = "medium";
};

bool has(const CLI::App& app, const char* option) {
  return app.get_option(option)->count() > 0;
}

void addPlaying(CLI::App& app, PlayerOptions& options, Given& given) {
  app.add_option("SCENE", options.scene, "a scene that overcast-bake wrote (.gltf)");
  app.add_flag("--headless", options.headless, "render pictures without a window");
  app.add_option("--frames", given.frames, "first:last frame, both included, or one frame (default 0)");
  app.add_option("--size", given.size, "WIDTHxHEIGHT in pixels (default 1280x720)");
  app.add_option("-o,--output", options.outputs,
                 "picture files, .png (as shown) or .exr (linear R G B and sky visibility), with #### or "
                 "%04d for the frame number; may be given twice")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false);
  app.add_option("--fps", options.framesPerSecond, "frames per second of the animation")
      ->check(CLI::Range(1e-3, 1e6))
      ->capture_default_str();
  app.add_option("--camera", given.camera, "px,py,pz,tx,ty,tz[,fov]: eye, target, vertical field of view in degrees");
  app.add_option("--device", options.device, "index or part of the name of the Vulkan device (default: the best GPU, else the CPU)");
  app.add_flag("--list-devices", options.listDevices, "list the Vulkan devices and end");
  app.add_flag("--validate", options.validate, "with Vulkan's core and synchronization validation; any message makes exit code 1");
  app.add_flag("--json", options.json, "the result as JSON on stdout");
}

void addShading(CLI::App& app, PlayerOptions& options, Given& given) {
  app.add_option("--resolution", given.resolution, "voxels along the longest side of the global volume (default: the scene's)")
      ->check(CLI::Range(32, 256));
  app.add_option(
         "--taps", given.taps,
         fmt::format("taps of the sky estimator at 128 voxels (default: the scene's); without --estimator, of a scene that is lit by "
                     "rays, which read none: of {}, or {} over apertures",
                     tapsEstimator(false), tapsEstimator(true)))
      ->check(CLI::Range(1, shared::kMaxTaps));
  app.add_option("--estimator", given.estimator,
                 fmt::format("sky estimator: {} (default: the scene's, which is {} where nobody chose another, and {} over apertures)",
                             fmt::join(kEstimators, ", "), Estimator{}.name, kBestHybrid))
      ->check(CLI::IsMember(std::vector<std::string>(kEstimators.begin(), kEstimators.end())))
      ->type_name("NAME");
  app.add_option("--aperture-mode", options.apertureMode,
                 "how lights shine through apertures: exact, smoothstep (as published), fast or accurate (default)")
      ->transform(CLI::CheckedTransformer(kApertureModes, CLI::ignore_case).description(""));
  app.add_option("--technique", options.technique.technique,
                 "how sky visibility is found: overcast (default: the scene's estimator), or what else there is: " + otherTechniques())
      ->transform(CLI::CheckedTransformer(techniques(), CLI::ignore_case).description(""));
  app.add_option("--constant", options.technique.constant, "sky visibility of --technique constant")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--gtao-quality", given.gtaoQuality, "of --technique gtao: low, medium or high")
      ->check(CLI::IsMember(gtaoQualities()))
      ->capture_default_str();
  app.add_option("--gtao-radius", given.gtaoRadius, "metres that --technique gtao searches (default: twice the width of the scene)")
      ->check(CLI::Range(1e-9, 1e9));
  app.add_option("--surfel-nearness", options.technique.surfelNearness,
                 "radii within which --technique surfels looks at what a disc stands for: more is slower and finer")
      ->check(CLI::Range(1e-3, 1e3))
      ->capture_default_str();
}

void addSky(CLI::App& app, PlayerOptions& options, Daylight& day) {
  auto* hour = app.add_option("--time-of-day", day.start, "sun and sky as at this hour, at time 0 (default: as the scene has them)")
                   ->check(CLI::Range(0.0, 24.0));
  app.add_option("--hours-per-second", day.hoursPerSecond, "how fast the day passes, from --time-of-day on")
      ->check(CLI::Range(-1e3, 1e3))
      ->needs(hour)
      ->capture_default_str();
  app.add_option_function<double>(
         "--sun-radius", [&day](double degrees) { day.sunRadius = degrees * std::numbers::pi / 180.0; },
         "degrees from the middle of that sun to its rim: wider suns have softer shadows (default: the scene's, else 0.27)")
      ->check(CLI::Range(0.01, 30.0))
      ->needs(hour);
  app.add_option("--sky", options.sky, "an EXR, latitude-longitude or cube, that is the sky (default: as the scene has it)");
}

void addQuality(CLI::App& app, PlayerOptions& options) {
  app.add_option("--level-error", options.levelError, "pixels by which terrain may be off for fewer triangles; 0: all triangles")
      ->check(CLI::Range(0.0, 1e3))
      ->capture_default_str();
  app.add_flag("!--no-resample", options.resample,
               "composite radius fields and heightfields as they are, not as small volumes made at load: slower, less memory");
  app.add_option("--supersample", options.supersample, "samples per pixel along a side")->check(CLI::Range(1, 8))->capture_default_str();
}

/// What is given becomes options; a usage error where it cannot.
void takeGiven(const CLI::App& app, const Given& given, PlayerOptions& options) {
  std::pair<int, int> range{0, 0}, sides{options.width, options.height};
  if (!given.frames.empty()) take("--frames", parseFrames(given.frames), range);
  if (!given.size.empty()) take("--size", parseSize(given.size), sides);
  if (!given.camera.empty()) take("--camera", parseCamera(given.camera), options.camera);
  std::tie(options.firstFrame, options.lastFrame) = range;
  std::tie(options.width, options.height) = sides;
  if (has(app, "--resolution")) options.resolution = given.resolution;
  if (has(app, "--taps")) options.taps = given.taps;
  if (has(app, "--estimator")) options.estimator = given.estimator;
  for (const NamedGtaoSearch& quality : kGtaoQualities)
    if (given.gtaoQuality == quality.name) options.technique.gtaoSearch = quality.search;
  if (has(app, "--gtao-radius")) options.technique.gtaoRadius = given.gtaoRadius;
  if (has(app, "--time-of-day")) options.daylight = given.day;
}

}  // namespace

ParsedOptions parseOptions(int argc, char** argv) {
  ParsedOptions parsed;
  PlayerOptions& options = parsed.options;
  CLI::App app("Plays a baked scene: sky light from composited distance volumes.", "overcast-player");
  app.footer(kFooter);
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  Given given;
  addPlaying(app, options, given);
  addShading(app, options, given);
  addSky(app, options, given.day);
  addQuality(app, options);
  parsed.exitCode = parseArguments(app, argc, argv, [&] {
    takeGiven(app, given, options);
    check(options);
  });
  return parsed;
}

bool hasFrameNumber(const std::string& pattern) {
  return std::regex_search(pattern, placeholder());
}

std::string pictureFile(const std::string& pattern, int frame) {
  std::smatch match;
  if (!std::regex_search(pattern, match, placeholder())) return pattern;
  const bool hashes = match[0].str()[0] == '#';
  const auto digits = hashes ? match[0].length() : match[1].length() > 0 ? std::stoi(match[1]) : 1;
  return match.prefix().str() + fmt::format("{:0{}}", frame, digits) + match.suffix().str();
}

}  // namespace overcast
