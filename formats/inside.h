// Inside: what the inside of a baked occluder is. Stored by name (DESIGN 4).
#pragma once

#include <optional>
#include <string_view>

namespace overcast {

enum class Inside {
  unstated,  ///< by assets of older bakers
  solid,     ///< the mesh is closed: every point is inside or outside
  open,    ///< the mesh has boundary edges; inside is where its winding number exceeds a half, which is a matter of definition at openings
  partly,  ///< some parts are as above, others are sheets: these have a thickness and no inside of their own
  none,    ///< sheets alone: two sides and a thickness
};

/// The name that assets store, and back; nothing when none has the name. `unstated` is the empty name.
const char* name(Inside inside);
std::optional<Inside> insideNamed(std::string_view name);

}  // namespace overcast
