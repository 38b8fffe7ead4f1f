#include "bake/defects.h"

#include <utility>

#include "bake/bake_report.h"

namespace overcast {
namespace {

constexpr double kUndecided = 0.05;      ///< share of the volume from which on it is mentioned
constexpr std::uint64_t kMany = 10;      ///< components
constexpr double kNoticeable = 0.01;     ///< share of a surface
constexpr std::uint64_t kSoupShare = 2;  ///< triangles per component

class List {
 public:
  void add(bool found, const char* name, std::string text) {
    if (found) defects_.push_back({name, std::move(text)});
  }
  std::vector<Defect> take() { return std::move(defects_); }

 private:
  std::vector<Defect> defects_;
};

void addOrientation(const MeshBake& mesh, List& list) {
  const MeshDiagnosis& found = mesh.found;
  list.add(found.boundaryEdges > 0 && !mesh.heights, "open",
           counted(found.boundaryEdges, "boundary edge", "boundary edges") + ": inside is decided by the winding number");
  list.add(found.inconsistentEdges > 0, "inconsistent",
           "turned " + counted(found.reorientedTriangles, "triangle", "triangles") + " to agree with their neighbours");
  list.add(found.turnedOutward > 0, "unoriented",
           "turned " + counted(found.turnedOutward, "triangle", "triangles") + " outward: the orientation as given decided nothing");
  list.add(found.insideOut, "inside-out", "is inside out: its inside was taken as solid all the same");
}

void addCounts(const MeshBake& mesh, List& list) {
  const MeshDiagnosis& found = mesh.found;
  list.add(found.nonManifoldEdges > 0, "non-manifold",
           counted(found.nonManifoldEdges, "edge has", "edges have") + " more than two triangles: they count as they are");
  list.add(found.duplicateTriangles > 0, "duplicates",
           "left out " + counted(found.duplicateTriangles, "duplicate triangle", "duplicate triangles"));
  list.add(found.degenerateTriangles > 0, "degenerate",
           counted(found.degenerateTriangles, "triangle has", "triangles have") + " no area: kept for the distance");
  const bool soup = found.components > 1 && found.components * kSoupShare >= mesh.faces;
  list.add(soup, "soup", "is a soup: " + grouped(found.components) + " pieces of " + counted(mesh.faces, "triangle", "triangles"));
  list.add(!soup && found.components >= kMany, "components", grouped(found.components) + " components, joined as they lie");
}

void addSurface(const MeshBake& mesh, List& list) {
  // A sheet of heights neither passes through itself nor has two sides: it only folds back within the tolerance of these checks.
  if (mesh.heights) return;
  const SurfaceReport& surface = mesh.surface;
  const std::string checked =
      surface.edgesChecked < surface.edges ? " of the " + grouped(surface.edgesChecked) + " looked at" : std::string();
  list.add(surface.edgesPiercing > 0, "self-intersecting",
           counted(surface.edgesPiercing, "edge", "edges") + checked + " pass through the surface: the union of what overlaps is inside");
  list.add(surface.innerShare > kNoticeable, "interior-walls",
           fmt::format("{:.0f} % of the surface lies inside: distances within end there", 100.0 * surface.innerShare));
  list.add(surface.thinShare > kNoticeable, "thin",
           fmt::format("{:.0f} % of the surface has its other side within {:.3g}: finer voxels would show it", 100.0 * surface.thinShare,
                       surface.thin));
}

void addField(const MeshBake& mesh, List& list) {
  list.add(mesh.ambiguousSign > kUndecided && !mesh.heights, "undecided",
           fmt::format("inside and outside are a matter of opinion for {:.0f} % of the volume: the mesh is far from closed",
                       100.0 * mesh.ambiguousSign));
  const Occluder& occluder = mesh.occluder;
  if (!mesh.volume || !(occluder.sheetThickness > 0.0)) return;
  list.add(true, "sheets",
           fmt::format("{}: the sheets have two sides and a thickness of {:.3g} ({:.2f} voxels)",
                       occluder.inside == Inside::none ? "has no inside" : "has sheets beside its solids", occluder.sheetThickness,
                       occluder.sheetThickness / mesh.volume->voxelSize));
}

}  // namespace

std::vector<Defect> defectsOf(const MeshBake& mesh) {
  List list;
  addOrientation(mesh, list);
  addCounts(mesh, list);
  addSurface(mesh, list);
  addField(mesh, list);
  return list.take();
}

}  // namespace overcast
