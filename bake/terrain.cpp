#include <algorithm>
#include <cmath>
#include <utility>

#include "bake/terrain_mesh.h"

namespace overcast {
namespace {

constexpr int kMostSweeps = 2000;
constexpr double kOverRelaxation = 1.8;  ///< of the sweeps (Young 1954); between 1 and 2 it converges
constexpr double kFlatEnough = 1e-4;     ///< of the spacing: sweeps end when no height changes by more
constexpr glm::vec4 kGround{0.40f, 0.34f, 0.26f, 1.0f};

std::size_t placeIn(const Terrain& terrain, int column, int row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(terrain.columns) + static_cast<std::size_t>(column);
}

/// Calls visit for the places beside one.
template <class Visit>
void forBeside(const Terrain& terrain, std::size_t place, const Visit& visit) {
  const auto columns = static_cast<std::size_t>(terrain.columns);
  if (place % columns > 0) visit(place - 1);
  if (place % columns + 1 < columns) visit(place + 1);
  if (place >= columns) visit(place - columns);
  if (place + columns < terrain.heights.size()) visit(place + columns);
}

/// Places without height that no way of such leads from to the border, in order.
std::vector<std::size_t> gapsIn(const Terrain& terrain) {
  std::vector<char> outside(terrain.heights.size(), 0);
  std::vector<std::size_t> open;
  const auto reach = [&](std::size_t place) {
    if (outside[place] || !std::isnan(terrain.heights[place])) return;
    outside[place] = 1;
    open.push_back(place);
  };
  for (int column = 0; column < terrain.columns; ++column)
    for (const int row : {0, terrain.rows - 1}) reach(placeIn(terrain, column, row));
  for (int row = 0; row < terrain.rows; ++row)
    for (const int column : {0, terrain.columns - 1}) reach(placeIn(terrain, column, row));
  while (!open.empty()) {
    const std::size_t place = open.back();
    open.pop_back();
    forBeside(terrain, place, reach);
  }
  std::vector<std::size_t> gaps;
  for (std::size_t i = 0; i < outside.size(); ++i)
    if (std::isnan(terrain.heights[i]) && !outside[i]) gaps.push_back(i);
  return gaps;
}

/// First heights for the gaps, ring by ring: the mean of what is there already.
void growInto(Terrain& terrain, std::vector<std::size_t> gaps) {
  std::vector<std::pair<std::size_t, float>> ring;
  while (!gaps.empty()) {
    ring.clear();
    for (const std::size_t place : gaps) {
      double sum = 0.0;
      int count = 0;
      forBeside(terrain, place, [&](std::size_t beside) {
        if (std::isnan(terrain.heights[beside])) return;
        sum += double{terrain.heights[beside]};
        ++count;
      });
      if (count > 0) ring.emplace_back(place, static_cast<float>(sum / count));
    }
    for (const auto& [place, height] : ring) terrain.heights[place] = height;
    std::erase_if(gaps, [&](std::size_t place) { return !std::isnan(terrain.heights[place]); });
  }
}

std::uint64_t missingIn(const Terrain& terrain) {
  return static_cast<std::uint64_t>(std::count_if(terrain.heights.begin(), terrain.heights.end(), [](float h) { return std::isnan(h); }));
}

}  // namespace

std::uint64_t fillGaps(Terrain& terrain) {
  const std::vector<std::size_t> gaps = gapsIn(terrain);
  growInto(terrain, gaps);
  std::vector<double> heights(terrain.heights.begin(), terrain.heights.end());
  const double enough = kFlatEnough * std::min(terrain.spacing.x, terrain.spacing.y);
  double largest = enough + 1.0;
  for (int sweep = 0; sweep < kMostSweeps && largest > enough && !gaps.empty(); ++sweep) {
    largest = 0.0;
    for (const std::size_t place : gaps) {
      double sum = 0.0;
      forBeside(terrain, place, [&](std::size_t beside) { sum += heights[beside]; });
      const double change = kOverRelaxation * (0.25 * sum - heights[place]);
      heights[place] += change;
      largest = std::max(largest, std::abs(change));
    }
  }
  for (const std::size_t place : gaps) terrain.heights[place] = static_cast<float>(heights[place]);
  return gaps.size();
}

Result<Scene> sceneFromTerrain(Terrain terrain, const std::string& name) {
  std::vector<std::string> notes = std::move(terrain.notes);
  if (const std::uint64_t filled = fillGaps(terrain); filled > 0)
    notes.push_back(fmt::format("{} heights missing within the terrain were filled from around them", filled));
  if (const std::uint64_t missing = missingIn(terrain); missing > 0)
    notes.push_back(fmt::format("{} heights missing at its outline were left out: the terrain ends there", missing));
  auto mesh = terrainMesh(terrain);
  if (!mesh) return mesh.error();
  mesh.value().name = name;
  Scene scene = sceneFromMesh(std::move(mesh).value());
  scene.materials[0] = {"ground", kGround};
  scene.notes.insert(scene.notes.end(), notes.begin(), notes.end());
  return scene;
}

}  // namespace overcast
