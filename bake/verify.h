// Verify: whether a baked scene tells the truth about its occluders and apertures, by measuring them again from the source meshes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/result.h"
#include "formats/terrain.h"

namespace overcast {

/// Two measurements of the same asset at the same points agree to this share of the figure, plus kVerifySlack of the mesh's diagonal (of 1
/// for the sky): what other compilers and instruction sets may round differently, with much to spare.
inline constexpr double kVerifyTolerance = 0.01;
inline constexpr double kVerifySlack = 1e-6;

/// One line per finding, each naming the node; empty when all is well. Every occluder's source (by file name, and mesh name in a scene) is
/// looked for among `sources`; its asset is read (file, content hash), its bounds, sign method and Lipschitz bound are compared, and its
/// error is measured anew with the stated samples and seed (bake/measure.h): every stated figure must come out again. An asset that states
/// no error, or one of a method this program does not know, is a finding. Apertures at vertices: bake/verify_apertures.h; aperture maps:
/// not measured. `terrain`: as given to the bake. An Error when `scene` or a source cannot be read.
Result<std::vector<std::string>> verify(const std::filesystem::path& scene, const std::vector<std::filesystem::path>& sources,
                                        const TerrainOptions& terrain = {});

}  // namespace overcast
