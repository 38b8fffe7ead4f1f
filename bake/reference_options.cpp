#include "bake/reference_options.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "bake/command.h"

namespace overcast {
namespace {

/// Quantities by their names; all when none is named.
void chooseQuantities(const std::vector<std::string>& names, TraceSettings& trace) {
  if (names.empty()) return;
  const auto has = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  trace.sky = has("sky");
  trace.light = has("light");
  trace.bounce = has("bounce");
}

struct NamedCamera {
  std::string name;
  std::optional<CameraOption> camera;
};

Result<std::vector<NamedCamera>> camerasOf(const ReferenceOptions& options) {
  std::vector<NamedCamera> cameras;
  if (options.pointsOnly) return cameras;
  for (const std::string& text : options.cameras) {
    if (text == "scene") {
      cameras.push_back({text, std::nullopt});
      continue;
    }
    const auto camera = parseCamera(text);
    if (!camera) return Error{"", "--camera", camera.error().reason};
    cameras.push_back({text, camera.value()});
  }
  if (cameras.empty()) cameras.push_back({"scene", std::nullopt});
  return cameras;
}

}  // namespace

void addReferenceOptions(CLI::App& app, ReferenceOptions& options) {
  app.add_option("SCENE", options.scene, "a plain or baked .gltf or .glb")->required();
  app.add_option("-o,--output", options.folder, "folder for view<camera>_<frame>.exr and .json, and points_<frame>.exr and .json")
      ->required();
  app.add_option("--frames", options.frames, "first:last frame, both included, or one frame")->capture_default_str();
  app.add_option("--fps", options.framesPerSecond, "frames per second of the animation")
      ->check(CLI::Range(1e-3, 1e6))
      ->capture_default_str();
  app.add_option("--size", options.size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  app.add_option("--camera", options.cameras,
                 "px,py,pz,tx,ty,tz[,fov]: eye, target, vertical field of view in degrees; or scene: the scene's camera, else one that "
                 "shows all of it [scene]. May be given several times")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false);
  app.add_option("--sky", options.sky,
                 "EXR of the sky (latitude and longitude, top row up, middle +z; or a cube), instead of the scene's own");
  app.add_option("--points", options.points, "also so many points spread evenly over all surfaces")
      ->check(CLI::Range(std::uint64_t{0}, kMostPoints));
  app.add_flag("--points-only", options.pointsOnly, "no views");
  app.add_option("--quantities", options.quantities, "sky (with dome, ao and colour), light, bounce, separated by commas [all]")
      ->delimiter(',')
      ->check(CLI::IsMember({"sky", "light", "bounce"}));
  app.add_option("--ao-distance", options.trace.distanceBound, "metres beyond which ao takes what rays hit for free [no bound: ao = sky]")
      ->check(positiveNumber);
  auto* error = app.add_option("--error", options.trace.error,
                               "trace until the mean standard error is below this: of visibilities, and of colours relative to the mean of "
                               "all reflected light or, where that is more, a white surface under the open sky")
                    ->check(numberWithin(1e-5, 1.0))
                    ->capture_default_str();
  app.add_option("--max-samples", options.trace.mostSamples, "rays per point and quantity at which that ends at the latest")
      ->check(CLI::Range(kReplicates * kFirstRays, kMostSamples))
      ->capture_default_str();
  app.add_option("--samples", options.trace.samples, "exactly so many rays per point and quantity (rounded up to a power of two) instead")
      ->check(CLI::Range(kReplicates * kFirstRays, kMostSamples))
      ->excludes(error);
  app.add_option("--seed", options.trace.seed, "of the random rays")->capture_default_str();
  app.add_option("--cache", options.cache, "folder of results that are taken instead of tracing the same again; may be shared [none]");
  app.add_option("--threads", options.threads, "threads to use [all]")->check(CLI::Range(1, 4096));
  app.add_flag("--preview", options.preview, "also a .png of each: sky, ao and all light, side by side");
  app.add_flag("--json", options.json, "print one JSON document instead of file names");
  app.add_flag("-q,--quiet", options.quiet, "no progress and no notes");
}

Result<std::vector<ReferenceJob>> referenceJobs(ReferenceOptions& options) {
  const auto frames = parseFrames(options.frames);
  if (!frames) return Error{"", "--frames", frames.error().reason};
  const auto size = parseSize(options.size);
  if (!size) return Error{"", "--size", size.error().reason};
  const auto cameras = camerasOf(options);
  if (!cameras) return cameras.error();
  if (options.pointsOnly && options.points == 0) return Error{"", "--points-only", "needs --points"};
  chooseQuantities(options.quantities, options.trace);
  std::vector<ReferenceJob> jobs;
  for (int frame = frames.value().first; frame <= frames.value().second; ++frame) {
    ReferenceJob job;
    job.frame = frame;
    job.time = frame / options.framesPerSecond;
    std::tie(job.width, job.height) = size.value();
    for (std::size_t i = 0; i < cameras.value().size(); ++i) {
      job.camera = cameras.value()[i].camera;
      job.cameraName = cameras.value()[i].name;
      job.json = options.folder / fmt::format("view{}_{:04}.json", i, frame);
      jobs.push_back(job);
    }
    job.points = options.points;
    job.json = options.folder / fmt::format("points_{:04}.json", frame);
    if (options.points > 0) jobs.push_back(job);
  }
  return jobs;
}

}  // namespace overcast
