#include "runtime/player/headless.h"

#include "formats/image.h"
#include "formats/view_options.h"

namespace overcast {
namespace {

std::optional<Failure> writePictures(const Device& device, const FrameRenderer& renderer, const PlayerOptions& options, int frame,
                                     PlayResult& result) {
  for (const std::string& pattern : options.outputs) {
    const std::string file = pictureFile(pattern, frame);
    const bool linear = std::filesystem::path(file).extension() == ".exr";
    const Result<Image> picture = linear ? readLinear(device, renderer) : readDisplay(device, renderer);
    if (!picture) return Failure{picture.error(), ExitCode::noDevice};
    const Result<Done> written = linear ? writeExr(file, picture.value()) : writePng(file, picture.value());
    if (!written) return Failure{written.error(), ExitCode::unwritable};
    result.pictures.push_back(file);
  }
  return std::nullopt;
}

std::optional<Failure> playFrames(const Device& device, FrameRenderer& renderer, const RuntimeScene& scene, const PlayerOptions& options,
                                  PlayResult& result) {
  for (int frame = options.firstFrame; frame <= options.lastFrame; ++frame) {
    const double time = frame / options.framesPerSecond;
    Result<std::vector<PassTime>> times = renderFrame(device, renderer, scene, time, viewOf(options, scene, time));
    if (!times) return Failure{times.error(), ExitCode::noDevice};
    result.frames.push_back(std::move(times).value());
    result.triangles.push_back(renderer.triangles);
    if (auto failure = writePictures(device, renderer, options, frame, result)) return failure;
  }
  return std::nullopt;
}

}  // namespace

FrameSettings frameSettings(const PlayerOptions& options) {
  FrameSettings settings{options.width, options.height,       options.supersample, options.resolution,
                         options.taps,  options.apertureMode, options.daylight};
  settings.technique = options.technique;
  settings.estimator = options.estimator;
  settings.levelError = options.levelError;
  settings.resample = options.resample;
  return settings;
}

View viewOf(const PlayerOptions& options, const RuntimeScene& scene, double time) {
  return chooseView(scene.scene, scene.bounds, options.camera, time, static_cast<double>(options.width) / options.height);
}

std::optional<Failure> playHeadless(const Device& device, const RuntimeScene& scene, const PlayerOptions& options, PlayResult& result) {
  result.device = device.info;
  Result<FrameRenderer> renderer = makeFrameRenderer(device, scene, frameSettings(options));
  if (!renderer) return Failure{renderer.error(), renderer.error().file.empty() ? ExitCode::noDevice : ExitCode::internal};
  auto failure = playFrames(device, renderer.value(), scene, options, result);
  destroyFrameRenderer(device, renderer.value());
  return failure;
}

}  // namespace overcast
