// Options: the command line of overcast-player.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/result.h"
#include "formats/view_options.h"
#include "runtime/daylight.h"
#include "runtime/passes/aperture/aperture_pass.h"
#include "runtime/technique.h"

namespace overcast {

struct PlayerOptions {
  std::filesystem::path scene;
  bool headless = false;
  int firstFrame = 0;
  int lastFrame = 0;  ///< included
  int width = 1280;
  int height = 720;
  std::vector<std::string> outputs;  ///< patterns of picture files
  double framesPerSecond = 30.0;
  std::optional<CameraOption> camera;
  std::string device;
  bool listDevices = false;
  bool validate = false;
  bool json = false;
  std::optional<int> resolution;
  std::optional<int> taps;
  std::optional<std::string> estimator;
  int supersample = 2;
  ApertureMode apertureMode = ApertureMode::accurate;
  std::optional<Daylight> daylight;
  TechniqueSettings technique;
  std::filesystem::path sky;  ///< an EXR in place of the scene's sky; empty: none
  double levelError = 1.0;
  bool resample = true;
};

/// What the command line says, or the exit code when there is nothing to do any more (help was shown, or a usage error reported).
struct ParsedOptions {
  PlayerOptions options;
  std::optional<int> exitCode;
};
ParsedOptions parseOptions(int argc, char** argv);

/// The file for one frame: the first run of # in the pattern, or its %d, %4d or %04d, becomes the frame number, zero-padded.
std::string pictureFile(const std::string& pattern, int frame);
/// Whether a pattern has a place for the frame number.
bool hasFrameNumber(const std::string& pattern);

}  // namespace overcast
