#include "runtime/player/measure_command.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "formats/console.h"
#include "runtime/flip.h"
#include "runtime/metrics.h"
#include "runtime/player/command.h"
#include "runtime/player/options.h"

namespace overcast {
namespace {

struct Options {
  std::string picture;
  std::string reference;
  std::string frames;
  std::vector<std::string> channels;
  std::vector<std::string> against;
  std::string flip;
  double pixelsPerDegree = kFlipPixelsPerDegree;
  bool json = false;
  std::pair<int, int> range{0, 0};
};

struct FrameMetrics {
  int frame = 0;
  ErrorMetrics error;
  double ssim = 0.0;
  double flip = 0.0;
};

struct ClipMetrics {
  std::vector<std::string> channels;
  std::vector<FrameMetrics> frames;
  Flicker flicker;
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("picture", options.picture, ".exr of overcast-player; of a clip with a # for the frame number")->required();
  app.add_option("reference", options.reference, ".exr of overcast-bake reference, or any other of the same size; of a clip with a #")
      ->required();
  app.add_option("--frames", options.frames, "first:last frame of a clip, both included; adds its flicker");
  app.add_option("--channels", options.channels, "one channel or three, separated by commas (default: sky where both have it, else R,G,B)")
      ->delimiter(',');
  app.add_option("--against", options.against, "what these are called in the reference, for example dome (default: the same)")
      ->delimiter(',')
      ->needs(app.get_option("--channels"));
  app.add_option("--flip", options.flip, ".png for the map of FLIP, black where nothing differs; of a clip with a #");
  app.add_option("--pixels-per-degree", options.pixelsPerDegree, "of visual angle, for FLIP (default: 67, a 4K monitor seen from 0.7 m)")
      ->check(CLI::Range(1.0, 1000.0));
  app.add_flag("--json", options.json, "one JSON object instead of a table");
}

/// What the command line got wrong in a way that single options do not show, or nothing.
void checkTogether(Options& options) {
  if (!options.channels.empty() && options.channels.size() != 1 && options.channels.size() != 3)
    throw CLI::ValidationError("--channels", "takes one or three");
  if (!options.against.empty() && options.against.size() != options.channels.size())
    throw CLI::ValidationError("--against", "takes as many as --channels");
  if (options.frames.empty()) return;
  const auto range = parseFrames(options.frames);
  if (!range) throw CLI::ValidationError("--frames", range.error().reason);
  options.range = range.value();
  const bool several = options.range.first != options.range.second;
  for (const std::string& pattern : {options.picture, options.reference, options.flip})
    if (several && !pattern.empty() && !hasFrameNumber(pattern))
      throw CLI::ValidationError("--frames", pattern + " has no # for the frame number");
}

std::string fileOf(const Options& options, const std::string& pattern, int frame) {
  return options.frames.empty() ? pattern : pictureFile(pattern, frame);
}

std::vector<std::string> defaultChannels(const Image& picture, const Image& reference) {
  const bool sky = channelIndex(picture, "sky") >= 0 && channelIndex(reference, "sky") >= 0;
  return sky ? std::vector<std::string>{"sky"} : std::vector<std::string>{"R", "G", "B"};
}

/// Gives the channels named `from` the names `to`; others that have these names lose them.
void rename(std::vector<std::string>& channels, const std::vector<std::string>& from, const std::vector<std::string>& to) {
  for (std::string& channel : channels) {
    const auto found = std::find(from.begin(), from.end(), channel);
    if (found != from.end()) {
      channel = to[static_cast<std::size_t>(found - from.begin())];
    } else if (std::find(to.begin(), to.end(), channel) != to.end()) {
      channel.clear();
    }
  }
}

/// An Error about two images, with the file in front.
Failure incomparable(Error error, const std::string& file) {
  error.file = file;
  return {std::move(error), ExitCode::unreadable};
}

std::optional<Failure> measureFrame(const Options& options, int frame, ClipMetrics& clip) {
  const std::string file = fileOf(options, options.picture, frame);
  const auto picture = readExr(file);
  auto reference = readExr(fileOf(options, options.reference, frame));
  if (!picture) return Failure{picture.error(), ExitCode::unreadable};
  if (!reference) return Failure{reference.error(), ExitCode::unreadable};
  if (!options.against.empty()) rename(reference.value().channels, options.against, options.channels);
  if (clip.channels.empty()) clip.channels = defaultChannels(picture.value(), reference.value());
  const Mask mask = surfaceMask(reference.value());
  const Comparison comparison{picture.value(), reference.value(), clip.channels, mask};
  const auto error = errorMetrics(comparison);
  if (!error) return incomparable(error.error(), file);
  const auto ssim = structuralSimilarity(comparison);
  const auto map = flip(comparison, options.pixelsPerDegree);
  if (!ssim || !map) return incomparable(ssim ? map.error() : ssim.error(), file);
  if (const auto added = addFrame(clip.flicker, comparison); !added) return incomparable(added.error(), file);
  clip.frames.push_back({frame, error.value(), ssim.value(), map.value().mean});
  if (options.flip.empty()) return std::nullopt;
  const auto written = writePng(fileOf(options, options.flip, frame), flipPicture(map.value(), reference.value().width));
  return written ? std::nullopt : std::optional(Failure{written.error(), ExitCode::unwritable});
}

std::string table(const ClipMetrics& clip) {
  std::string lines =
      fmt::format("channels: {}\n{:>6} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}\n", fmt::join(clip.channels, ","), "frame",
                  "pixels", "rmse", "bias", "mae", "p95", "p99", "max", "ssim", "flip");
  for (const FrameMetrics& f : clip.frames)
    lines += fmt::format("{:>6} {:>9} {:>8.4f} {:>+8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f}\n", f.frame, f.error.pixels,
                         f.error.rmse, f.error.bias, f.error.mae, f.error.p95, f.error.p99, f.error.max, f.ssim, f.flip);
  if (clip.frames.size() > 1)
    lines += fmt::format("flicker: {:.5f} from frame to frame, at most {:.4f}\n", flickerRms(clip.flicker), clip.flicker.largest);
  return lines;
}

std::string json(const ClipMetrics& clip) {
  nlohmann::ordered_json root;
  root["channels"] = clip.channels;
  for (const FrameMetrics& f : clip.frames)
    root["frames"].push_back({{"frame", f.frame},
                              {"pixels", f.error.pixels},
                              {"rmse", f.error.rmse},
                              {"bias", f.error.bias},
                              {"mae", f.error.mae},
                              {"p95", f.error.p95},
                              {"p99", f.error.p99},
                              {"max", f.error.max},
                              {"ssim", f.ssim},
                              {"flip", f.flip}});
  if (clip.frames.size() > 1) root["flicker"] = {{"rms", flickerRms(clip.flicker)}, {"max", clip.flicker.largest}};
  return root.dump(2) + "\n";
}

}  // namespace

int measureCommand(int argc, char** argv) {
  CLI::App app(
      "Measures pictures against references, on linear values, where the reference shows surfaces (its channel depth is at least 0).",
      "overcast-player measure");
  Options options;
  addOptions(app, options);
  if (const auto code = parseArguments(app, argc, argv, [&] { checkTogether(options); })) return *code;
  ClipMetrics clip{options.channels, {}, {}};
  for (int frame = options.range.first; frame <= options.range.second; ++frame)
    if (const auto failure = measureFrame(options, frame, clip)) return fail(*failure);
  printResult(options.json ? json(clip) : table(clip));
  return static_cast<int>(ExitCode::ok);
}

}  // namespace overcast
