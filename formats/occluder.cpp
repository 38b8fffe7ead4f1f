#include "formats/occluder.h"

#include <algorithm>
#include <array>

namespace overcast {
namespace {

/// In the order of the enumeration.
constexpr std::array kNames = {
    "volume",
    "primitive",
    "radius",
    "heightfield",
};

}  // namespace

const char* name(Representation representation) {
  const auto index = static_cast<std::size_t>(representation);
  OVERCAST_REQUIRE(index < kNames.size(), "representation {} of {}", index, kNames.size());
  return kNames[index];
}

std::optional<Representation> representationNamed(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Representation>(found - kNames.begin());
}

}  // namespace overcast
