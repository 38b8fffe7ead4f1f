// Scenes: what the project shows and measures itself on. All stand on or in closed slabs with thickness, y up, metres.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/scene.h"

namespace overcast {

/// A sphere of radius 0.5 m resting on a slab whose top is y = 0.
Scene makeSphereOnPlane();

/// Evans 2006, figure 10: five walls, red left and green right, and an oriented cube. The room is 2 m wide, open towards +z.
Scene makeCornellBox();

/// Evans 2006, figure 11a: the same room with a shape in the cube's place that folds around itself.
Scene makeCornellKnot();

/// Evans 2006, figure 11b: the same room with a star.
Scene makeCornellStar();

/// Fourteen simple objects on a slab, five of them moving.
Scene makeClutter();

/// A statue on a plinth under a small warm and a large blue lamp, both moving, and little sky. The ground knows nothing of the statue.
Scene makeStatueTwoLights(Mesh statue);

/// Oat and Sander 2006, figure 8: what an aperture cannot tell. A sphere hovers over a plane, both of one mesh: points under it see a ring
/// of sky, which no cap is like, while a lamp goes round.
Scene makeSphereOverPlane();

inline constexpr std::array<const char*, 3> kScannedMeshes = {"elephant", "bunny00", "armadillo"};

/// `objects` objects of seven shapes over a slab, all moving: at most half turn on the ground, the others tumble or rise and fall above it.
/// They are smaller the more there are, and never meet. 1 to 4096 objects; the same seed gives the same scene.
Scene makeMovingClutter(int objects, std::uint64_t seed);

/// A closed room, 4 m by 5 m and 2.6 m high, with furniture, a lamp that swings, and light through one window only. The wall with the
/// window is one mesh.
Scene makeRoomWithWindow();

/// Stairs between thin things: walls of 3 cm, fins, a door that opens, a railing. Thinner than a voxel of the global volume.
Scene makeStairsAndThinWalls();

/// Plants of thin leaves that sway, each leaf an instance, and tufts of grass.
Scene makeFoliage();

/// A scene to fit constants on: one of clutter, blocks, a room, thin walls, or rods, cards and leaves, of random shapes, sizes (from 0.1 to
/// 10 times those above), proportions and camera. Any seed; the same gives the same scene.
Scene makeRandomScene(std::uint64_t seed);

/// Three scanned meshes of Debian's libcgal-demo, read from `folder` as NAME.off, beside shapes of ours. A mesh that is not there or cannot
/// be read is replaced by a torus knot, and `notes` says so.
Scene makeDefault(const std::filesystem::path& folder, std::vector<std::string>& notes);

}  // namespace overcast
