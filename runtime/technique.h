// Technique: how the sky visibility of a pixel is found: by Overcast's own estimators, or by what a user would otherwise take. All give the
// same picture: light image alpha is sky visibility, its colour that of the sky's light; the report compares them.
#pragma once

#include <array>

namespace overcast {

enum class Technique {
  overcast,     ///< the scene's estimator, or its apertures
  constant,     ///< one value everywhere
  coneTracing,  ///< nine cones through the global volume
  rays16,       ///< rays through the global volume
  rays64,
};

struct NamedTechnique {
  const char* name;
  Technique technique;
};

/// As --technique and the report name them; in the order of Technique.
inline constexpr std::array<NamedTechnique, 5> kTechniques{{{"overcast", Technique::overcast},
                                                            {"constant", Technique::constant},
                                                            {"cone-tracing", Technique::coneTracing},
                                                            {"rays16", Technique::rays16},
                                                            {"rays64", Technique::rays64}}};

constexpr const char* nameOf(Technique technique) {
  return kTechniques[static_cast<std::size_t>(technique)].name;
}

/// Whether the technique reads the global volume; for the others none is made.
constexpr bool readsVolume(Technique technique) {
  return technique != Technique::constant;
}

/// Whether pixels take turns with their samples, so that the denoise pass must follow.
constexpr bool denoises(Technique technique) {
  return technique == Technique::rays16 || technique == Technique::rays64;
}

}  // namespace overcast
