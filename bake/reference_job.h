// Reference job: one file of truth, traced unless it is there already.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "bake/cache.h"
#include "bake/reference.h"
#include "formats/view_options.h"

namespace overcast {

/// What one file is to hold. A view, or points when `points` is not 0.
struct ReferenceJob {
  std::filesystem::path json;  ///< where it goes; the picture beside it
  int frame = 0;
  double time = 0.0;                   ///< seconds
  std::optional<CameraOption> camera;  ///< of a view; none: the scene's (chooseView)
  std::string cameraName = "scene";    ///< as it was given
  int width = 0;                       ///< of a view
  int height = 0;
  std::uint64_t points = 0;
  const SkyImage* sky = nullptr;  ///< instead of the scene's; null: none
};

enum class ReferenceOutcome {
  traced,
  upToDate,  ///< the files were there, whole and of the same inputs and settings
  cached,    ///< taken from the cache
  stopped,   ///< by `progress`; nothing was written
  badScene,  ///< there is nothing to see, or memory ran out; see error
  cannotWrite
};

struct ReferenceReport {
  ReferenceOutcome outcome = ReferenceOutcome::traced;
  ReferenceInfo info;  ///< of the file, when there is one
  Error error;
};

/// Sees to it that the file of `job` is there. The time of an animation says where things are; a file is traced anew only when what rays
/// meet (tracedHash), the view, the settings or kTraceVersion changed. `cache` may be null. With `preview` a .png lies beside it.
ReferenceReport runReferenceJob(const Scene& scene, const std::string& sceneName, const ReferenceJob& job, const TraceSettings& settings,
                                Cache* cache, bool preview, const Progress& progress = {});

/// Raised when tracing gives other numbers than before.
inline constexpr int kTraceVersion = 1;

}  // namespace overcast
