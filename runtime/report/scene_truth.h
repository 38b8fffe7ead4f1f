// SceneTruth: the references of a scene, found by what rays meet in it.
#pragma once

#include <filesystem>
#include <vector>

#include "formats/reference.h"
#include "runtime/metrics.h"

namespace overcast {

struct TruthPicture {
  Reference reference;
  Mask mask;  ///< surfaces that the reference shows
};

struct SceneTruth {
  std::vector<TruthPicture> pictures;  ///< by camera, then by frame; all of one size
};

/// The views in `folder` and in the folders in it whose sceneHash is that of `scene` at their time. Errors name the folder when there are
/// none, and the file that is broken, has no sky, or is of another size than the first.
Result<SceneTruth> readTruth(const std::filesystem::path& folder, const std::filesystem::path& scene);

/// The views and the points likewise, of any size, by folder and name; not empty.
Result<std::vector<Reference>> readReferences(const std::filesystem::path& folder, const std::filesystem::path& scene);

/// RMS of the standard error of `sky` where `mask` is not 0; 0 where the reference does not say.
double standardError(const Image& reference, const Mask& mask);

}  // namespace overcast
