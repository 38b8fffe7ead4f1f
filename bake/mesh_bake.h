// Mesh bake: one mesh becomes the file of its occluder, with everything that is known about it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bake/aperture.h"
#include "bake/aperture_map.h"
#include "bake/choose.h"
#include "bake/examine.h"
#include "bake/volume.h"
#include "formats/asset.h"
#include "formats/mesh.h"

namespace overcast {

/// Part of every hash: raise it when the same input would bake to other bytes.
inline constexpr int kBakerVersion = 1;

/// How a mesh is baked: as a volume with these settings, or, where there are settings for it, as what the choice finds best.
struct BakeSettings {
  VolumeSettings volume;
  std::optional<ChoiceSettings> choice;
};

/// All settings that change what a bake makes, as text: equal exactly when all of them are.
std::string settingsText(const BakeSettings& settings);

/// Hash of geometry, settings and baker: meshes of the same hash bake to the same bytes.
std::string meshHash(const Mesh& mesh, const BakeSettings& settings);

/// Samples of a baked volume.
struct VolumeShape {
  glm::ivec3 size{0};
  double voxelSize = 0.0;
};

/// One mesh of a scene and what became of it. Meshes with the same geometry share one bake.
struct MeshBake {
  int mesh = -1;       ///< index into SceneBake::scene.meshes
  int input = -1;      ///< index into SceneBake::inputs
  std::string source;  ///< "bunny.off", or "truck.glb: wheel"
  int sameAs = -1;     ///< index of the MeshBake whose asset this one shares, or -1
  std::string hash;    ///< meshHash
  std::uint64_t faces = 0;
  bool heights = false;  ///< made from a height file: open by design
  double seconds = 0.0;
  bool cached = false;                ///< came from the cache
  std::optional<EncodedAsset> asset;  ///< as stored; empty when shared or failed
  std::optional<VolumeShape> volume;  ///< of a volume
  MeshDiagnosis found;
  double ambiguousSign = 0.0;                    ///< BakedVolume or Probes
  std::uint64_t sheetTriangles = 0;              ///< BakedVolume
  SurfaceReport surface;                         ///< thin: a voxel of a volume, a hundredth of the diagonal of anything else
  std::optional<MeasuredError> inBox;            ///< BakedVolume::error, without choice
  std::optional<ChoiceRecord> choice;            ///< with choice
  std::optional<ApertureReport> apertures;       ///< where vertices were given apertures (bake/scene_apertures.h)
  std::optional<ApertureMapReport> apertureMap;  ///< where the mesh was given a map of them
  std::vector<std::byte> mapBytes;               ///< its file, until it is written
  std::optional<Error> error;
  Occluder occluder;  ///< with `asset`: all of it but the uri and the source, which writeBake fills in
};

/// Bakes one mesh, measures what came out and fills `job` from `asset` to `occluder`, except `error`. Same result for any thread count. An
/// Error without a file when the mesh cannot be baked with these settings or `progress` asked to stop ("interrupted").
Result<Done> bakeMesh(MeshBake& job, const Mesh& mesh, const BakeSettings& settings, const Progress& progress = {});

}  // namespace overcast
