// Occluder: what the glTF node extension OVERCAST_occluder says (DESIGN 4). Schema: formats/schema/OVERCAST_occluder.schema.json
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "formats/inside.h"
#include "formats/mesh.h"
#include "formats/primitive.h"

namespace overcast {

/// Which of the papers' occluder representations an asset holds (DESIGN 5.1). Stored by name.
enum class Representation { volume, primitive, radius, heightfield };

/// Measured error of a baked representation against the exact distance to its source mesh, at seeded random points. `method` names the
/// points: "influence-2" is that of bake/measure.h, "influence-1" the same with one reading of open sheets; empty, the first method, took
/// points of the box alone and has the first five figures.
struct MeasuredError {
  double max = 0.0;              ///< largest |phi - exact|, local units
  double rms = 0.0;              ///< root mean square of phi - exact, local units
  std::uint64_t signErrors = 0;  ///< points of wrong sign that are clearly off the surface, as the method has it
  std::uint64_t samples = 0;     ///< number of points; 0: nothing was measured
  std::uint64_t seed = 0;        ///< seed of their positions
  double p99 = -1.0;             ///< |phi - exact| that 99 of 100 points stay within, local units; negative: not measured, as below
  double surfaceRms = -1.0;      ///< root mean square near the surface, local units: what a representation is chosen by
  double skyRmse = -1.0;         ///< root mean square error of the sky visibility on receivers around the object, 0 to 1
  std::string method;
};

inline constexpr int kOccluderVersion = 1;

/// One baked occluder, in the local space of the node's mesh.
struct Occluder {
  Representation representation = Representation::volume;
  std::string uri;                        ///< file beside the glTF; empty for a primitive
  std::string contentHash;                ///< of that file (formats/files.h); empty for a primitive
  std::uint64_t bytes = 0;                ///< of that file; kPrimitiveBytes for a primitive
  int bits = 0;                           ///< of a volume's stored values: 8, 16 or 32; 0: not said
  std::optional<Primitive> primitive;     ///< exactly when the representation is primitive
  Box bounds;                             ///< box within which the representation is defined
  double influenceRadius = 0.0;           ///< distance beyond the bounds up to which it is meant to occlude
  double lipschitz = 1.7320508075688772;  ///< bound on |grad phi| of the runtime's distance or lower bound of it; culling uses it
  Inside inside = Inside::unstated;
  double sheetThickness = 0.0;  ///< Volume::sheetThickness
  std::string signMethod;       ///< bake/sign.h
  MeasuredError error;
  std::string source;        ///< file name (no folder) and mesh it was baked from
  std::string settingsHash;  ///< hash of source bytes and bake settings
};

/// The name that the extension stores, and back; nothing when no representation has the name.
const char* name(Representation representation);
std::optional<Representation> representationNamed(std::string_view name);

}  // namespace overcast
