// Reference trace: light that arrives at points of a scene, by random rays, with its standard error. Private to bake.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/progress.h"
#include "bake/traced_scene.h"

namespace overcast {

/// Independent estimates of everything, whose spread gives the standard error.
inline constexpr std::uint32_t kReplicates = 8;
/// Fewest rays for each of them: those of the first round; every further round doubles them.
inline constexpr std::uint32_t kFirstRays = 16;
inline constexpr std::uint32_t kMostSamples = std::uint32_t{1} << 20;

struct TraceSettings {
  bool sky = true;             ///< sky, dome, ao, colour
  bool light = true;           ///< light, where the scene has any
  bool bounce = true;          ///< bounce
  double distanceBound = 0.0;  ///< of ao, metres; 0: none
  double error = 0.003;        ///< mean standard error to reach: of sky, dome and ao; of colours times the mean of all reflected light
                               ///< or, where that is more, times what a white surface reflects under the open sky
  std::uint32_t samples = 0;   ///< rays for each point instead of an error to reach; rounded up to kReplicates times a power of two
  std::uint32_t mostSamples = 65536;  ///< rays for each point at which it gives up; at most kMostSamples
  std::uint64_t seed = 1;
};

/// One quantity (formats/reference.h) at all points.
struct TracedQuantity {
  std::string name;
  std::size_t channels = 1;
  std::vector<float> values;  ///< [point * channels + channel]
  std::vector<float> errors;  ///< standard error at each point, of three channels the root of the mean of their squares
  std::uint64_t samples = 0;  ///< rays for each point; of `light` for each light
  double mean = 0.0;          ///< of all values
  double meanError = 0.0;
  double largestError = 0.0;
};

/// What arrives at each point. Hemisphere rays are distributed as the cosine to the shading normal, rays to lights evenly over the solid
/// angle of their discs; a bounce adds one such ray of each kind where it hits. In rounds that double the rays, for each kind of ray by
/// itself, until its error is reached. The same for any number of threads. Nothing when `progress` stopped it.
std::optional<std::vector<TracedQuantity>> traceQuantities(const TracedScene& scene, std::span<const TracedSurface> points,
                                                           const TraceSettings& settings, const Progress& progress = {});

}  // namespace overcast
