// Scenes: what the project shows and measures itself on. All stand on or in closed slabs with thickness, y up, metres.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/scene.h"

namespace overcast {

/// A sphere of radius 0.5 m resting on a slab whose top is y = 0.
Scene makeSphereOnPlane();

/// Evans 2006, figure 10: five walls, red left and green right, and an oriented cube. The room is 2 m wide, open towards +z.
Scene makeCornellBox();

/// Evans 2006, figure 11: the same room with a star in the cube's place.
Scene makeCornellStar();

/// Fourteen simple objects on a slab, five of them moving.
Scene makeClutter();

inline constexpr std::array<const char*, 3> kScannedMeshes = {"elephant", "bunny00", "armadillo"};

/// Three scanned meshes of Debian's libcgal-demo, read from `folder` as NAME.off, beside shapes of ours. A mesh that is not there or cannot
/// be read is replaced by a torus knot, and `notes` says so.
Scene makeDefault(const std::filesystem::path& folder, std::vector<std::string>& notes);

}  // namespace overcast
