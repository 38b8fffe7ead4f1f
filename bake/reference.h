// Reference: ray-traced truth of a scene for views and for points on its surfaces (formats/reference.h says what is in one).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bake/progress.h"
#include "bake/reference_trace.h"
#include "formats/camera.h"
#include "formats/reference.h"
#include "formats/result.h"
#include "formats/scene.h"

namespace overcast {

/// Rays through the pixel centres of a picture, as overcast-player --supersample 1 draws it.
struct ReferenceView {
  View view;
  int width = 0;
  int height = 0;
};

/// Truth through `view`. The info's sizes, view, bound, target, seed, seconds and quantities are set. Nothing when `progress` stopped it.
std::optional<Reference> traceView(const TracedScene& scene, const ReferenceView& view, const TraceSettings& settings,
                                   const Progress& progress = {});

/// Truth at `count` points evenly at random over the surfaces, on their outer sides, but for points within solids, which are drawn again.
/// Fewer where nearly all surface lies within solids.
std::optional<Reference> tracePoints(const TracedScene& scene, std::uint64_t count, const TraceSettings& settings,
                                     const Progress& progress = {});

inline constexpr std::uint64_t kMostPoints = std::uint64_t{1} << 24;

/// All settings that change what is traced, as text: equal exactly when all of them are.
std::string settingsText(const TraceSettings& settings);

/// The reference for the eye: rows of sky, ao and all light together (display-encoded, light times `exposure`), side by side.
Image previewOf(const Reference& reference, double exposure);

}  // namespace overcast
