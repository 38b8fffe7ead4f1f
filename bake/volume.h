// `volume`: bakes a mesh into a local signed-distance volume and measures the error it makes.
#pragma once

#include <cstdint>

#include "bake/distance.h"
#include "bake/progress.h"
#include "bake/repair.h"
#include "formats/occluder.h"
#include "formats/volume.h"

namespace overcast {

/// One bake of a volume. The defaults are those of the command line.
struct VolumeSettings {
  int resolution = 32;     ///< voxels along the longest side of the padded box (Evans 2006, figure 11a), 8 to 512
  double voxelSize = 0.0;  ///< local units; when positive it decides the resolution instead
  double padding = 2.0;    ///< voxels between the mesh's box and the outermost samples
  VolumeBits bits = VolumeBits::automatic;
  std::uint64_t errorSamples = 4096;  ///< random points at which the error is measured; 0 leaves it out
  std::uint64_t seed = 1;
};

struct BakedVolume {
  Volume volume;
  MeshDiagnosis found;
  MeasuredError error;         ///< of the trilinear interpolant of `volume` as stored, against the exact distance
  double ambiguousSign = 0.0;  ///< SignField::ambiguous
};

/// The grid the settings ask for around `box`: every side padded, the longest with `resolution` samples, voxels cubic.
/// An Error when voxel size or resolution give a grid outside 2 .. kMaxVolumeSide per side, or the box is empty or not finite.
Result<Grid> volumeGrid(const Box& box, const VolumeSettings& settings);

/// Repairs, takes distance and sign, measures. An Error when the mesh has no triangle with an extent, or `progress` asked to stop.
Result<BakedVolume> bakeVolume(const Mesh& mesh, const VolumeSettings& settings, const Progress& progress = {});

}  // namespace overcast
