// MeasureScene: error, time and memory of every setting of the sweep in one scene.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/report.h"
#include "runtime/report/scene_truth.h"
#include "runtime/scene.h"
#include "runtime/vulkan/device.h"

namespace overcast {

struct MeasureSettings {
  int timedWidth = 640;  ///< pixels of the pictures that are timed
  int timedHeight = 360;
  int rounds = 7;  ///< timed frames of each setting, after one that warms up
  bool quick = false;
  std::function<void(const std::string&)> progress;  ///< told what is being done, in a few words; may be empty
};

/// What a setting makes of the first reference.
struct MeasuredPicture {
  std::string setting;
  Image image;  ///< channel sky
};

struct MeasuredScene {
  ReportScene scene;
  TruthPicture truth;                     ///< the first reference, its mask narrowed to the surfaces that the player shows too
  std::vector<MeasuredPicture> pictures;  ///< one for each row, in order
};

/// Measures `scene`, whose lighting and apertures are as before afterwards. Every picture is rendered at the size of its reference and
/// compared on the surfaces that both show. Times are of the view of the first reference: in each round every setting draws one frame, in
/// alternating order, so that a device that slows down slows all of them; the global volume is made anew in each, as if everything moved.
Result<MeasuredScene> measureScene(const Device& device, RuntimeScene& scene, const std::string& name, SceneTruth truth,
                                   const MeasureSettings& settings);

}  // namespace overcast
