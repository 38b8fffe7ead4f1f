#include "runtime/resample.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <tbb/parallel_for.h>
#include <glm/matrix.hpp>

#include "runtime/passes/composite/composite_object.h"
#include "runtime/passes/composite/heightfield_object.h"
#include "runtime/passes/composite/radius_object.h"
#include "runtime/scene.h"

namespace overcast {
namespace {

std::uint64_t samplesOf(const Volume& volume) {
  return static_cast<std::uint64_t>(volume.size.x) * static_cast<std::uint64_t>(volume.size.y) * static_cast<std::uint64_t>(volume.size.z);
}

/// A volume's place without its distances, and its axes.
std::optional<Resampled> placeOf(const Asset& asset, double voxel) {
  Resampled made;
  Box box = bounds(asset);
  if (const auto* field = std::get_if<HeightField>(&asset)) {
    made.localFromVolume = field->localFromField;
    const glm::dvec3 middle = glm::transpose(field->localFromField) * field->origin;
    box = {middle - field->halfExtent, middle + field->halfExtent};
  } else if (!std::holds_alternative<RadiusField>(asset)) {
    return {};
  }
  if (!(voxel > 0.0)) return {};
  Volume& volume = made.volume;
  const glm::dvec3 half = 0.5 * extent(box) + kResamplePadding * voxel;
  for (int density = kMostDensity; density >= kLeastDensity; --density) {
    volume.voxelSize = voxel / density;
    // An odd number about the middle: a flat sheet has samples on it.
    const glm::dvec3 steps = glm::ceil(half / volume.voxelSize);
    if (!(2.0 * std::max({steps.x, steps.y, steps.z}) < kMaxVolumeSide)) continue;
    volume.size = 2 * glm::ivec3(steps) + 1;
    volume.origin = centre(box) - volume.voxelSize * steps;
    if (density == kLeastDensity || samplesOf(volume) <= kFineResamples) return made;
  }
  return {};
}

double sampleLevel(const HeightField& field, const glm::dvec3& point, int level) {
  return sampleHeightField(field, point, level);
}
double sampleLevel(const RadiusField& field, const glm::dvec3& point, int level) {
  return sampleRadius(field, point, level);
}

/// A row of samples at a time, in any order.
template <class Field>
void sampleField(const Field& field, int level, Resampled& made) {
  Volume& volume = made.volume;
  volume.distance.resize(samplesOf(volume));
  tbb::parallel_for(0, volume.size.y * volume.size.z, [&](int row) {
    const int j = row % volume.size.y, k = row / volume.size.y;
    float* to = volume.distance.data() + sampleIndex(volume, 0, j, k);
    for (int i = 0; i < volume.size.x; ++i) {
      const glm::dvec3 at = volume.origin + volume.voxelSize * glm::dvec3(i, j, k);
      *to++ = static_cast<float>(sampleLevel(field, made.localFromVolume * at, level));
    }
  });
}

}  // namespace

std::optional<Resampled> resampled(const Asset& asset, double voxel, std::uint64_t most, int longest) {
  std::optional<Resampled> made = placeOf(asset, voxel);
  if (!made) return {};
  Volume& volume = made->volume;
  if (samplesOf(volume) > most || std::max({volume.size.x, volume.size.y, volume.size.z}) > longest) return {};
  if (const auto* field = std::get_if<HeightField>(&asset))
    sampleField(*field, heightFieldLevel(*field, voxel), *made);
  else
    sampleField(std::get<RadiusField>(asset), radiusLevel(std::get<RadiusField>(asset), voxel), *made);
  return made;
}

std::vector<std::optional<Resampled>> resampledAll(std::span<const Asset> assets, std::span<const double> voxels, int longest,
                                                   std::uint64_t most) {
  OVERCAST_REQUIRE(voxels.size() == assets.size(), "{} sizes for {} assets", voxels.size(), assets.size());
  std::vector<std::uint64_t> samples;
  for (std::size_t i = 0; i < assets.size(); ++i) {
    const std::optional<Resampled> place = placeOf(assets[i], voxels[i]);
    samples.push_back(place ? samplesOf(place->volume) : 0);
  }
  std::vector<std::size_t> order(assets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return samples[a] < samples[b]; });
  std::vector<std::optional<Resampled>> all(assets.size());
  std::uint64_t left = most;
  for (const std::size_t i : order) {
    all[i] = resampled(assets[i], voxels[i], left, longest);
    if (all[i]) left -= samples[i];
  }
  return all;
}

std::vector<double> finestVoxels(const RuntimeScene& scene, const GlobalGrid& grid) {
  std::vector<double> largest(scene.assets.size(), 0.0);
  const double duration = animationDuration(scene.scene);
  const int times = duration > 0.0 ? kScaleTimes : 1;
  for (int n = 0; n < times; ++n) {
    const std::vector<glm::dmat4> nodes = worldFromLocal(scene.scene, times > 1 ? duration * n / (times - 1) : 0.0, false);
    for (const SceneObject& object : scene.objects)
      largest[object.asset] = std::max(largest[object.asset], singularValues(glm::dmat3(nodes[object.node])).x);
  }
  for (double& scale : largest) scale = scale > 0.0 ? grid.voxelSize / scale : 0.0;
  return largest;
}

}  // namespace overcast
