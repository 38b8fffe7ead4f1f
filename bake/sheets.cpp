#include "bake/sheets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/edges.h"
#include "bake/sign.h"
#include "bake/surface_samples.h"

namespace overcast {
namespace {

constexpr double kShortBoundary = 0.01;  ///< of the area, its length squared
constexpr double kPlate = 0.03;          ///< of the area's root, twice volume over area
constexpr std::size_t kSamples = 4096;
constexpr double kOwnSamples = 16.0;   ///< below that a component is decided with others
constexpr double kNearInteger = 0.2;   ///< as SignField::ambiguous has it
constexpr double kDecidedShare = 0.5;  ///< of the area

/// Sums over one component.
struct Component {
  double area = 0.0;
  double volume = 0.0;    ///< six times
  double boundary = 0.0;  ///< length
  glm::dvec3 apex{0.0};
  bool open = false;
};

/// Numbers the components in the order of their first triangle.
std::vector<std::uint32_t> componentsOf(const std::vector<glm::uvec3>& triangles, std::size_t& count) {
  TriangleSets sets = connectedPieces(triangles);
  std::vector<std::uint32_t> number(triangles.size());
  count = 0;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const std::uint32_t first = sets.find(i);
    number[i] = first == i ? static_cast<std::uint32_t>(count++) : number[first];
  }
  return number;
}

std::vector<Component> measureComponents(const Mesh& mesh, const std::vector<std::uint32_t>& number, std::size_t count) {
  std::vector<Component> components(count);
  for (std::size_t i = mesh.triangles.size(); i-- > 0;) components[number[i]].apex = mesh.positions[mesh.triangles[i].x];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    Component& component = components[number[i]];
    const glm::uvec3& t = mesh.triangles[i];
    const glm::dvec3 a = mesh.positions[t.x] - component.apex, b = mesh.positions[t.y] - component.apex,
                     c = mesh.positions[t.z] - component.apex;
    component.area += 0.5 * glm::length(glm::cross(b - a, c - a));
    component.volume += glm::dot(a, glm::cross(b, c));
  }
  forEachEdge(edgeUses(mesh.triangles), [&](auto first, auto last) {
    int net = 0;
    for (auto use = first; use != last; ++use) net += use->forward ? 1 : -1;
    if (net == 0) return;
    Component& component = components[number[first->triangle]];
    component.open = true;
    component.boundary += glm::distance(mesh.positions[first->low], mesh.positions[first->high]);
  });
  return components;
}

/// The triangles of `mesh` that are marked, or those that are not; vertices that only others use stay, unused.
Mesh partOf(const Mesh& mesh, std::span<const std::uint8_t> marked, bool wanted) {
  Mesh part;
  part.name = mesh.name;
  part.positions = mesh.positions;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if ((marked[i] != 0) == wanted) part.triangles.push_back(mesh.triangles[i]);
  return part;
}

double areaOf(const Mesh& mesh) {
  double area = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3& a = mesh.positions[t.x];
    area += 0.5 * glm::length(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a));
  }
  return area;
}

/// Marks the open components beside which the winding number decides nothing.
void decideOpen(const Mesh& mesh, const std::vector<Component>& components, SheetTable& table) {
  // Closed components add whole numbers to the winding number, which decide nothing here.
  std::vector<std::uint8_t> closed(mesh.triangles.size());
  for (std::size_t i = 0; i < closed.size(); ++i) closed[i] = components[table.component[i]].open ? 0 : 1;
  const SurfaceSamples samples = sampleSurface(mesh, kSamples, closed);
  if (samples.points.empty()) return;
  const Mesh open = partOf(mesh, closed, false);
  const std::vector<double> winding = windingAt(open, latticeGrid(open), samples.points);
  struct Tally {
    double all = 0.0;
    double decided = 0.0;
    bool undecided() const { return decided < kDecidedShare * all; }
  };
  std::vector<Tally> tallies(components.size());
  for (std::size_t i = 0; i < winding.size(); ++i) {
    Tally& tally = tallies[table.component[samples.triangle[i]]];
    tally.all += 1.0;
    // On both sides of a surface the winding number has the same fraction.
    tally.decided += std::abs(winding[i] - std::round(winding[i])) < kNearInteger ? 1.0 : 0.0;
  }
  Tally small;
  for (const Tally& tally : tallies) {
    if (tally.all >= kOwnSamples) continue;
    small.all += tally.all;
    small.decided += tally.decided;
  }
  for (std::size_t c = 0; c < components.size(); ++c) {
    const Component& component = components[c];
    if (!component.open || component.boundary * component.boundary < kShortBoundary * component.area) continue;
    table.undecided[c] = (tallies[c].all >= kOwnSamples ? tallies[c] : small).undecided() ? 1 : 0;
  }
}

}  // namespace

double leastThickness(double voxelSize) {
  return std::numbers::sqrt3 * voxelSize;
}

SheetTable sheetTable(const Mesh& mesh) {
  SheetTable table;
  std::size_t count = 0;
  table.component = componentsOf(mesh.triangles, count);
  const std::vector<Component> components = measureComponents(mesh, table.component, count);
  table.undecided.assign(count, 0);
  bool doubtful = false;
  for (const Component& component : components) {
    const double thickness = component.area > 0.0 ? std::abs(component.volume) / (3.0 * component.area) : 0.0;
    const bool plate = !component.open && component.area > 0.0 && thickness < kPlate * std::sqrt(component.area);
    table.plateThickness.push_back(plate ? thickness : std::numeric_limits<double>::infinity());
    doubtful |= component.open && component.boundary * component.boundary >= kShortBoundary * component.area;
  }
  if (doubtful) decideOpen(mesh, components, table);
  return table;
}

std::vector<std::uint8_t> findSheets(const SheetTable& table, SheetMode mode, double thickness) {
  if (mode == SheetMode::none) return {};
  std::vector<std::uint8_t> isSheet(table.component.size(), 0);
  bool any = false;
  for (std::size_t i = 0; i < isSheet.size(); ++i) {
    const std::uint32_t c = table.component[i];
    const bool thin = table.plateThickness[c] < thickness / std::numbers::sqrt3;
    isSheet[i] = mode == SheetMode::all || table.undecided[c] != 0 || thin ? 1 : 0;
    any |= isSheet[i] != 0;
  }
  if (!any) isSheet.clear();
  return isSheet;
}

SheetParts takeApart(Mesh mesh, std::span<const std::uint8_t> isSheet) {
  if (isSheet.empty()) return {std::move(mesh), {}};
  return {partOf(mesh, isSheet, false), partOf(mesh, isSheet, true)};
}

double sheetShare(const SheetParts& parts) {
  const double sheets = areaOf(parts.sheets), all = sheets + areaOf(parts.solids);
  return all > 0.0 ? sheets / all : 0.0;
}

Inside insideOf(const MeshDiagnosis& found, const SheetParts& parts) {
  if (parts.sheets.triangles.empty()) return found.closed ? Inside::solid : Inside::open;
  return parts.solids.triangles.empty() ? Inside::none : Inside::partly;
}

std::vector<double> fieldAt(const SheetParts& parts, double thickness, const Grid& grid, std::span<const glm::dvec3> points) {
  std::vector<double> field(points.size(), std::numeric_limits<double>::infinity());
  if (!parts.solids.triangles.empty()) {
    field = distanceAt(parts.solids, points);
    const std::vector<double> winding = windingAt(parts.solids, grid, points);
    for (std::size_t i = 0; i < field.size(); ++i)
      if (std::abs(winding[i]) > 0.5) field[i] = -field[i];
  }
  if (parts.sheets.triangles.empty()) return field;
  const std::vector<double> sheets = distanceAt(parts.sheets, points);
  for (std::size_t i = 0; i < field.size(); ++i) field[i] = std::min(field[i], sheets[i] - 0.5 * thickness);
  return field;
}

}  // namespace overcast
