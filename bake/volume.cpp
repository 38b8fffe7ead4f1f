#include "bake/volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <glm/common.hpp>

#include "bake/prepare.h"
#include "bake/random.h"
#include "bake/sign.h"

namespace overcast {
namespace {

Error failure(std::string reason) {
  return Error{"", "", std::move(reason)};
}

/// Samples nearest to the points that lie further than a tenth of a voxel from the surface on the wrong side. Samples and not the points
/// themselves: between samples the interpolant of even a perfect volume crosses the edges of a mesh.
std::uint64_t countSignErrors(const Volume& volume, const SheetParts& parts, const Grid& grid, std::span<const glm::dvec3> points) {
  std::vector<glm::dvec3> positions;
  std::vector<float> distances;
  for (const glm::dvec3& point : points) {
    const glm::ivec3 sample(glm::round((point - volume.origin) / volume.voxelSize));
    positions.push_back(volume.origin + volume.voxelSize * glm::dvec3(sample));
    distances.push_back(volume.distance[sampleIndex(volume, sample.x, sample.y, sample.z)]);
  }
  const std::vector<double> exact = fieldAt(parts, volume.sheetThickness, grid, positions);
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < positions.size(); ++i)
    count += std::abs(distances[i]) > 0.1 * volume.voxelSize && (distances[i] < 0.0f) != (exact[i] < 0.0) ? 1 : 0;
  return count;
}

MeasuredError measure(const Volume& volume, const SheetParts& parts, const Grid& grid, const VolumeSettings& settings) {
  if (settings.errorSamples == 0) return {};
  const Box box = bounds(volume);
  std::vector<glm::dvec3> points;
  points.reserve(settings.errorSamples);
  for (std::uint64_t i = 0; i < settings.errorSamples; ++i) {
    const glm::dvec3 share(uniform(settings.seed, 3 * i), uniform(settings.seed, 3 * i + 1), uniform(settings.seed, 3 * i + 2));
    points.push_back(box.min + share * extent(box));
  }
  const std::vector<double> exact = fieldAt(parts, volume.sheetThickness, grid, points);
  MeasuredError error;
  error.samples = settings.errorSamples;
  error.seed = settings.seed;
  double squares = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double difference = sampleVolume(volume, points[i]) - exact[i];
    error.max = std::max(error.max, std::abs(difference));
    squares += difference * difference;
  }
  error.rms = std::sqrt(squares / static_cast<double>(points.size()));
  error.signErrors = countSignErrors(volume, parts, grid, points);
  return error;
}

/// The caller's progress over the share `from` .. `to` of the whole.
Progress part(const Progress& whole, double from, double to) {
  if (!whole) return {};
  return [whole, from, to](double share) { return whole(from + share * (to - from)); };
}

/// The signed distance to the solids; false when asked to stop. Does nothing without solids.
bool fillSolids(const Mesh& solids, const Grid& grid, const Progress& progress, BakedVolume& baked) {
  if (solids.triangles.empty()) return true;
  Volume& volume = baked.volume;
  volume.distance = unsignedDistance(solids, grid, part(progress, 0.0, 0.8));
  if (volume.distance.empty()) return false;
  const SignField sign = signField(solids, grid, part(progress, 0.8, 1.0));
  if (sign.inside.empty()) return false;
  for (std::size_t i = 0; i < volume.distance.size(); ++i)
    if (sign.inside[i]) volume.distance[i] = -volume.distance[i];
  volume.signMethod = sign.method;
  baked.ambiguousSign = sign.ambiguous;
  return true;
}

/// Joins the sheets to the distances that are there; false when asked to stop.
bool addSheets(const Mesh& sheets, const Grid& grid, const Progress& progress, Volume& volume) {
  if (sheets.triangles.empty()) return true;
  std::vector<float> distance = unsignedDistance(sheets, grid, progress);
  if (distance.empty()) return false;
  const bool alone = volume.distance.empty();
  const auto half = static_cast<float>(0.5 * volume.sheetThickness);
  for (std::size_t i = 0; i < distance.size(); ++i)
    distance[i] = alone ? distance[i] - half : std::min(volume.distance[i], distance[i] - half);
  volume.distance = std::move(distance);
  if (alone) volume.signMethod = kTwoSided;
  return true;
}

Result<Done> checkSettings(const VolumeSettings& settings) {
  if (settings.voxelSize == 0.0 && (settings.resolution < kMinResolution || settings.resolution > kMaxResolution))
    return failure(fmt::format("resolution {} is outside {} to {}", settings.resolution, kMinResolution, kMaxResolution));
  if (!(settings.voxelSize >= 0.0) || !std::isfinite(settings.voxelSize))
    return failure(fmt::format("voxel size {} is not a positive number", settings.voxelSize));
  if (!(settings.sheets.thickness >= 0.0) || !std::isfinite(settings.sheets.thickness))
    return failure(fmt::format("sheet thickness {} is not a positive number", settings.sheets.thickness));
  if (!(settings.padding >= 0.0) || settings.padding > kMaxVolumeSide)
    return failure(fmt::format("padding of {} voxels is outside 0 to {}", settings.padding, kMaxVolumeSide));
  if (settings.voxelSize == 0.0 && 2.0 * settings.padding + 2.0 > settings.resolution)
    return failure(fmt::format("padding of {} voxels leaves no room at resolution {}", settings.padding, settings.resolution));
  return Done{};
}

}  // namespace

Result<Grid> volumeGrid(const Box& box, const VolumeSettings& settings) {
  if (const Result<Done> checked = checkSettings(settings); !checked) return checked.error();
  if (isEmpty(box)) return failure("mesh has no triangle");
  const glm::dvec3 size = extent(box);
  const double longest = std::max({size.x, size.y, size.z});
  if (!std::isfinite(longest)) return failure("mesh has vertices that are not finite");
  if (longest == 0.0) return failure("mesh has no extent: all its vertices are in one place");

  Grid grid;
  grid.voxelSize = settings.voxelSize > 0.0 ? settings.voxelSize : longest / (settings.resolution - 1 - 2.0 * settings.padding);
  // Distances are single floats: their steps must resolve a voxel, and the box must not overflow them.
  if (grid.voxelSize < 1e6 * double{std::numeric_limits<float>::min()})
    return failure(fmt::format("mesh is too small ({:.3g} units)", longest));
  if (longest > 0.1 * double{std::numeric_limits<float>::max()}) return failure(fmt::format("mesh is too large ({:.3g} units)", longest));
  for (int axis = 0; axis < 3; ++axis) {
    // A hair less than exact, so that rounding cannot add a sample to the side that fits.
    const double cells = std::max(std::ceil(size[axis] / grid.voxelSize + 2.0 * settings.padding - 1e-9), 1.0);
    if (cells + 1.0 > kMaxVolumeSide)
      return failure(fmt::format("voxel size {:.3g} gives {:.0f} samples along one side, at most {} are allowed", grid.voxelSize,
                                 cells + 1.0, kMaxVolumeSide));
    grid.size[axis] = static_cast<int>(cells) + 1;
  }
  grid.origin = centre(box) - 0.5 * grid.voxelSize * glm::dvec3(grid.size - 1);
  return grid;
}

Result<BakedVolume> bakeVolume(const Mesh& mesh, const VolumeSettings& settings, const Progress& progress) {
  const Box box = bounds(mesh);
  if (const Result<Grid> checked = volumeGrid(box, settings); !checked) return checked.error();
  PreparedMesh prepared = prepare(mesh);
  RepairedMesh& repaired = prepared.repaired;
  const Grid grid = volumeGrid(bounds(repaired.mesh), settings).value();

  BakedVolume baked;
  baked.found = repaired.found;
  Volume& volume = baked.volume;
  volume.size = grid.size;
  volume.origin = grid.origin;
  volume.voxelSize = grid.voxelSize;
  const double thickness = settings.sheets.thickness > 0.0 ? settings.sheets.thickness : leastThickness(grid.voxelSize);
  const std::vector<std::uint8_t> isSheet = findSheets(sheetTable(repaired.mesh), settings.sheets.mode, thickness);
  const SheetParts parts = takeApart(std::move(repaired.mesh), isSheet);
  volume.inside = insideOf(repaired.found, parts);
  baked.sheetTriangles = parts.sheets.triangles.size();
  if (baked.sheetTriangles > 0) volume.sheetThickness = thickness;
  if (!fillSolids(parts.solids, grid, part(progress, 0.0, baked.sheetTriangles > 0 ? 0.5 : 0.9), baked)) return failure("interrupted");
  if (!addSheets(parts.sheets, grid, part(progress, 0.5, 0.9), volume)) return failure("interrupted");
  volume = asStored(std::move(volume), settings.bits);
  if (!isWhole(volume)) return failure("distances do not fit the chosen precision; take single floats");
  baked.error = measure(volume, parts, grid, settings);
  volume.origin += prepared.middle;
  if (progress && !progress(1.0)) return failure("interrupted");
  return baked;
}

}  // namespace overcast
