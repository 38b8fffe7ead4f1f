// `volume`: bakes a mesh into a local signed-distance volume and measures the error it makes.
#pragma once

#include <cstdint>

#include "bake/distance.h"
#include "bake/progress.h"
#include "bake/repair.h"
#include "bake/sheets.h"
#include "formats/occluder.h"
#include "formats/volume.h"

namespace overcast {

inline constexpr int kMinResolution = 8;
inline constexpr int kMaxResolution = 512;

/// One bake of a volume. The defaults are those of the command line.
struct VolumeSettings {
  int resolution = 32;     ///< samples along the longest side of the padded box (Evans 2006, figure 11a), kMinResolution to kMaxResolution
  double voxelSize = 0.0;  ///< local units; when positive it decides the resolution instead
  double padding = 2.0;    ///< voxels between the mesh's box and the outermost samples
  VolumeBits bits = VolumeBits::automatic;
  SheetSettings sheets;
  std::uint64_t errorSamples = 4096;  ///< random points at which the error is measured; 0 leaves it out
  std::uint64_t seed = 1;
};

/// A volume with what was found on the way.
struct BakedVolume {
  Volume volume;  ///< as stored: distances already rounded to the chosen precision
  MeshDiagnosis found;
  MeasuredError error;  ///< of the trilinear interpolant of `volume` against the exact distance, by its own definition (bake/sheets.h)
  double ambiguousSign = 0.0;  ///< SignField::ambiguous, of what is not a sheet
  std::uint64_t sheetTriangles = 0;
};

/// The grid the settings ask for around `box`, centred on it: at least `padding` voxels on every side, the longest side with `resolution`
/// samples (or as many as voxelSize gives), voxels cubic. A side without extent gets the padding alone. An Error when a setting is out of
/// range, voxel size or padding give a grid outside 2 .. kMaxVolumeSide per side, or the box is empty, not finite or a single point.
Result<Grid> volumeGrid(const Box& box, const VolumeSettings& settings);

/// Repairs, takes sheets apart, takes distance and sign, measures. The mesh is recentred in double first, so that neither its place nor its
/// scale changes the result. Error points are evenly random in the box of samples and depend on the seed alone. An Error when volumeGrid
/// gives one, when distances do not fit the chosen precision, or when `progress` asked to stop ("interrupted").
Result<BakedVolume> bakeVolume(const Mesh& mesh, const VolumeSettings& settings, const Progress& progress = {});

}  // namespace overcast
