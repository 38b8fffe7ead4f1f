// Technique: how the sky visibility of a pixel is found: by Overcast's own estimators, or by what a user would otherwise take. All give the
// same picture: light image alpha is sky visibility, its colour that of the sky's light; the report compares them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

namespace overcast {

enum class Technique {
  overcast,     ///< the scene's estimator, or its apertures
  constant,     ///< one value everywhere
  gtao,         ///< horizons in the depth image
  coneTracing,  ///< nine cones through the global volume
  rays16,       ///< rays through the global volume
  rays64,
  surfels,  ///< discs on the surfaces that shadow each other and bounce light
};

/// How finely Technique::gtao searches, in each of the sixteen pixels that share their samples.
struct GtaoSearch {
  int slices = 3;  ///< at least 1
  int steps = 8;   ///< to each side of a slice, at least 1
  /// How far a horizon falls back towards samples below it in one search, 0 to 1: occluders are taken as about as thick as they are wide.
  float thickness = 0.2f;
};

struct NamedGtaoSearch {
  const char* name;
  GtaoSearch search;
};

/// As --gtao-quality names them.
inline constexpr std::array<NamedGtaoSearch, 3> kGtaoQualities{{{"low", {2, 4, 0.2f}}, {"medium", {3, 8, 0.2f}}, {"high", {4, 12, 0.2f}}}};

/// A technique and what it can be told.
struct TechniqueSettings {
  Technique technique = Technique::overcast;
  float constant = 0.5f;  ///< sky visibility of Technique::constant, 0 to 1
  GtaoSearch gtaoSearch;
  std::optional<double> gtaoRadius;  ///< metres, above 0; else twice the global volume's longest side
  double surfelNearness = 4.0;       ///< radii within which Technique::surfels looks at what a disc stands for, above 0
};

struct NamedTechnique {
  const char* name;
  Technique technique;
};

/// As --technique and the report name them; in the order of Technique.
inline constexpr std::array<NamedTechnique, 7> kTechniques{{{"overcast", Technique::overcast},
                                                            {"constant", Technique::constant},
                                                            {"gtao", Technique::gtao},
                                                            {"cone-tracing", Technique::coneTracing},
                                                            {"rays16", Technique::rays16},
                                                            {"rays64", Technique::rays64},
                                                            {"surfels", Technique::surfels}}};

constexpr const char* nameOf(Technique technique) {
  return kTechniques[static_cast<std::size_t>(technique)].name;
}

/// Whether the technique reads the global volume; for the others none is made.
constexpr bool readsVolume(Technique technique) {
  return technique != Technique::constant && technique != Technique::gtao && technique != Technique::surfels;
}

/// Whether pixels take turns with their samples, so that the denoise pass must follow.
constexpr bool denoises(Technique technique) {
  return technique == Technique::gtao || technique == Technique::rays16 || technique == Technique::rays64;
}

}  // namespace overcast
