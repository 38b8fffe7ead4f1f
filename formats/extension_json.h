// The JSON of the glTF extensions OVERCAST_occluder (on nodes), OVERCAST_lighting (on the scene), OVERCAST_aperture and
// OVERCAST_aperture_bake (on meshes). What each field means and may hold is in formats/schema/*.schema.json; these functions hold to the
// schemas.
#pragma once

#include <string>
#include <string_view>

#include "formats/aperture_bake.h"
#include "formats/aperture_link.h"
#include "formats/lighting.h"
#include "formats/occluder.h"
#include "formats/result.h"

namespace overcast {

/// One JSON object on one line, keys in the order of the schema. Doubles are written so that they read back bit for bit.
std::string occluderJson(const Occluder& occluder);
std::string lightingJson(const Lighting& lighting);
std::string apertureJson(const ApertureLink& link);
std::string apertureBakeJson(const ApertureBake& bake);

/// The double with the fewest digits that reads back as `value`: JSON then says 0.05 and not 0.05000000074505806.
double shortest(float value);

/// The struct that `json` describes. Unknown keys are ignored, so that later versions may add optional ones. An Error whose place is
/// `place` and the field at fault ("nodes/4/extensions/OVERCAST_occluder/bounds/min") when the text is no JSON object, a required field is
/// missing, a type or range is wrong, or `version` is newer than this code.
Result<Occluder> parseOccluder(std::string_view json, const std::string& place);
Result<Lighting> parseLighting(std::string_view json, const std::string& place);
Result<ApertureLink> parseAperture(std::string_view json, const std::string& place);
Result<ApertureBake> parseApertureBake(std::string_view json, const std::string& place);

}  // namespace overcast
