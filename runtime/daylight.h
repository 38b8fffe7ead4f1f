// Daylight: sun and sky of a scene by the time of day (Oat and Sander 2006, section 8.4.4: blue by day, red or pink at sunset, deep blue
// at night).
#pragma once

#include <optional>

#include "formats/lighting.h"

namespace overcast {

/// A day that passes while a scene plays.
struct Daylight {
  double start = 12.0;                             ///< hours at time 0, any number; 12: the sun is highest
  double hoursPerSecond = 0.0;                     ///< how fast the day passes
  std::optional<double> sunRadius = std::nullopt;  ///< radians, instead of the scene's: larger suns have softer shadows
};

/// `lighting` with sun and sky as they are at `hours` (taken modulo 24): the sun of an equinox at 45 degrees, rising in the east at 6,
/// south at 12, where east is cross(up, z) (x for up = y) and south cross(east, up). The colours of `lighting` are those of a sun in the
/// zenith (a scene without a sun gets a white one of irradiance 3); on its way through the air (Kasten and Young 1989) the sun loses blue
/// first, and is gone when its disc has set. Everything else stays as it was.
Lighting lightingAt(const Lighting& lighting, double hours);

/// What the sky's radiance is multiplied by at `hours`: lightingAt does so with Lighting::skyColour. A sky image is tinted by the same and
/// otherwise stays as it is, clouds and all: it does not turn with the sun.
glm::vec3 skyTintAt(const Lighting& lighting, double hours);

}  // namespace overcast
