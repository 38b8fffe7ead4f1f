// Resample: radius fields and heightfields as small volumes, made once when a scene is loaded. One evaluation of a volume takes the
// composite 6 ns on lavapipe, where a search takes 22 to 39 (`overcast-player cost`), its Lipschitz constant is 2 to 10 on the example
// scenes and not 3 to 123, so that culling leaves fewer objects to evaluate, and a scene without searches has shaders without them, which
// devices that run both sides of every branch under a mask would pay for at every other object.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>

#include "formats/asset.h"
#include "runtime/passes/composite/global_grid.h"

namespace overcast {

struct RuntimeScene;

/// Samples of a resampled asset along the side of a global voxel: as many as kFineResamples allows. Interpolation is off by half of their
/// spacing at most where the distance has a crease (thin sheets), by hundredths of a global voxel elsewhere: resample_test.cpp. The traced
/// sky of the foliage scene, of thin leaves, is off the truth by 0.055 (RMS), without resampling by 0.053.
inline constexpr int kMostDensity = 4;
inline constexpr int kLeastDensity = 2;
inline constexpr std::uint64_t kFineResamples = std::uint64_t{1} << 20;
/// Global voxels by which the volume goes beyond the asset's box; from there on it goes on as sampleVolume does.
inline constexpr double kResamplePadding = 2.0;
/// Of all of a scene's assets together, 32 MiB as half floats and about a second of loading: the smallest come first, and what no longer
/// fits stays as it is.
inline constexpr std::uint64_t kMostResamples = std::uint64_t{1} << 24;

/// A volume in axes of its own.
struct Resampled {
  Volume volume;
  glm::dmat3 localFromVolume{1.0};  ///< orthonormal: a heightfield's own axes
};

/// The distance of a radius field or heightfield as the composite would evaluate it (sampleRadius, sampleHeightField, at the level whose
/// texels suit a global voxel of the size `voxel`, local units), in samples of voxel / kMostDensity to voxel / kLeastDensity over its box
/// and kResamplePadding * voxel around it. Nothing for other kinds, where `voxel` is not
/// positive, and where it would take more than `most` samples or `longest` along a side. Deterministic for any number of threads.
std::optional<Resampled> resampled(const Asset& asset, double voxel, std::uint64_t most = kMostResamples, int longest = kMaxVolumeSide);

/// The same for each asset, of a size each, within `most` together.
std::vector<std::optional<Resampled>> resampledAll(std::span<const Asset> assets, std::span<const double> voxels, int longest,
                                                   std::uint64_t most = kMostResamples);

/// For each asset of the scene the size of a global voxel in local units where it is placed largest, at any of kScaleTimes times of the
/// animation; 0 where it is not placed.
std::vector<double> finestVoxels(const RuntimeScene& scene, const GlobalGrid& grid);
inline constexpr int kScaleTimes = 33;

}  // namespace overcast
