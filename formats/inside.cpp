#include "formats/inside.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace overcast {
namespace {

/// In the order of the enumeration.
constexpr std::array kNames = {"", "solid", "open", "partly", "none"};

}  // namespace

const char* name(Inside inside) {
  return kNames.at(static_cast<std::size_t>(inside));
}

std::optional<Inside> insideNamed(std::string_view name) {
  const auto* found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Inside>(found - kNames.begin());
}

}  // namespace overcast
