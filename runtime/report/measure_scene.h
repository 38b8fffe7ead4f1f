// MeasureScene: error, time and memory of every setting of the sweep in one scene.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/report.h"
#include "runtime/report/scene_truth.h"
#include "runtime/report/sweep.h"
#include "runtime/report/timing.h"
#include "runtime/scene.h"
#include "runtime/vulkan/device.h"

namespace overcast {

struct MeasureSettings {
  TimingSettings timing;
  SweepSize size = SweepSize::full;
  std::function<void(const std::string&)> progress;  ///< told what is being done, in a few words; may be empty
};

/// What a setting makes of the last reference.
struct MeasuredPicture {
  std::string setting;
  Image image;  ///< channel sky
};

struct MeasuredScene {
  ReportScene scene;
  SceneTruth truth;                       ///< masks narrowed to the surfaces that the player shows too
  std::vector<MeasuredPicture> pictures;  ///< one for each row, in order, of the last reference
  std::vector<double> factors;            ///< of all rounds of times (timing.h)
};

/// Measures `scene`, whose lighting and apertures are as before afterwards. Every picture is rendered at the size of its reference and
/// compared on the surfaces that both show. Where its error comes from, times and pictures are of the last reference: of the last frame,
/// by when what moves has moved.
Result<MeasuredScene> measureScene(const Device& device, RuntimeScene& scene, const std::string& name, SceneTruth truth,
                                   const MeasureSettings& settings);

/// Measures a further bake of a measured scene by the settings of SweepSize::variant and adds its rows, which `bake` tells apart. Its
/// references are the same: an Error otherwise.
Result<Done> measureVariant(const Device& device, RuntimeScene& scene, const std::string& bake, const MeasureSettings& settings,
                            MeasuredScene& measured);

/// "16 bits, up to 64 samples, primitive" and the like: what tells bakes of a scene apart.
std::string occludersOf(const RuntimeScene& scene);

/// Times the settings of a measured scene once more, none of further bakes: for each the ratio of its time while nothing moves to what it
/// was. What another run would differ by, seen within one.
Result<std::vector<double>> timeAgain(const Device& device, RuntimeScene& scene, const MeasuredScene& measured,
                                      const MeasureSettings& settings);

}  // namespace overcast
