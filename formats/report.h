// Report: error, time and memory of every way to light scenes, as `overcast-player report` measures them and `overcast-player compare`
// reads them. Schema: formats/schema/report.schema.json
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/result.h"

namespace overcast {

inline constexpr int kReportVersion = 1;

/// Milliseconds on the device over the measured rounds.
struct ReportTime {
  double median = 0.0;
  double p95 = 0.0;    ///< the smallest that 95 % of the rounds do not exceed
  double noise = 0.0;  ///< by how much the median of another run on the same device may differ, beside those of the other settings
  int rounds = 0;      ///< that were timed; of sums the fewest of their parts; 0: not said
};

struct ReportPass {
  std::string name;  ///< as the player's table names it
  ReportTime time;
};

/// One step from the truth to the picture (runtime/metrics.h, ErrorStep).
struct ReportStep {
  std::string name;
  double rms = 0.0;
  double bias = 0.0;
  double share = 0.0;
};

/// Sky visibility against the reference, over all frames and the surfaces that both show.
struct ReportErrors {
  double rmse = 0.0;
  double rmseCorrected = 0.0;  ///< what is left of it without the reference's own standard error
  double bias = 0.0;           ///< above 0: too bright
  double mae = 0.0;
  double p95 = 0.0;  ///< of the frames the largest, as p99 and max
  double p99 = 0.0;
  double max = 0.0;
  double ssim = 0.0;
  double flip = 0.0;
  double flicker = -1.0;      ///< RMS change of the error between consecutive frames; below 0: there are none
  std::vector<double> views;  ///< RMSE of each of ReportScene::views; empty: not said
};

/// What one setting reaches in one scene.
struct ReportRow {
  std::string setting;       ///< its name, the same in every scene; unique within one
  std::string technique;     ///< as --technique names it
  std::string estimator;     ///< of technique overcast; else empty
  int resolution = 0;        ///< voxels along the longest side of the global volume; 0: needs none
  int taps = 0;              ///< of an estimator that reads some; else 0
  int cones = 0;             ///< of an estimator that has some and of which the setting says how many; else 0
  std::string apertureMode;  ///< where the scene has apertures and the setting reads them; else empty
  std::string occluders;     ///< how the scene was baked: precision and size of its local occluders
  std::string bake;          ///< of a further bake of the scene, measured beside the first: what tells it apart; else empty
  bool storable = false;     ///< a scene's lighting can say it: a budget may choose it
  ReportErrors errors;
  ReportTime frame;  ///< all passes, while everything moves: the whole volume is made anew. Sum of `still` and the passes that rest
  ReportTime still;  ///< the same without the passes that rest while nothing moves
  std::vector<ReportPass> passes;
  std::uint64_t gpuBytes = 0;     ///< on the device, beyond what a frame without any occlusion takes
  std::uint64_t assetBytes = 0;   ///< files of the local occluders it reads
  std::vector<ReportStep> steps;  ///< where its error comes from; empty: not told apart
};

/// A reference that the pictures of a scene are compared with.
struct ReportView {
  std::string camera;
  int frame = 0;
  double time = 0.0;  ///< seconds
};

struct ReportScene {
  std::string name;               ///< of the file, without folder and ending
  std::string hash;               ///< tracedHash at the time of the first reference
  int pictures = 0;               ///< references compared: cameras times frames
  std::uint64_t pixels = 0;       ///< compared, of the last picture
  double referenceError = 0.0;    ///< RMS of the reference's standard error over them
  std::uint64_t seed = 0;         ///< of the reference
  std::vector<ReportView> views;  ///< what is compared, by camera, then by frame; empty: not said
  std::vector<ReportRow> rows;
};

struct Report {
  std::string device;
  std::string kind;
  std::string driver;
  std::string vulkan;
  int width = 0;  ///< pixels of the pictures that errors are of
  int height = 0;
  int timedWidth = 0;  ///< pixels of those that times are of
  int timedHeight = 0;
  int rounds = 0;       ///< timed frames of each setting, at most; slow ones have fewer (ReportTime::rounds)
  double drift = 0.0;   ///< by what share (of logarithms) all times together may differ from run to run: how busy or fast the device was
  std::string leftOut;  ///< what this report does not sweep, in words; empty: nothing
  std::vector<ReportScene> scenes;
};

/// The row of a setting, or null.
const ReportRow* rowNamed(const ReportScene& scene, std::string_view setting);

std::string reportJson(const Report& report);
/// Errors name the field that is missing, wrong or out of range, or the version when it is a later one.
Result<Report> parseReport(std::string_view json, const std::string& place);
Result<Report> readReport(const std::filesystem::path& path);

}  // namespace overcast
