// Sheets: the parts of a mesh that have no inside - leaves, cloth, terrain, a soup that no orientation fits - or are thinner than a field
// can hold, and the field that gives them two sides and a thickness instead of holes.
//
// A field with sheets is phi = min(signed distance to the solids, distance to the sheets - thickness / 2): the exact distance to solids and
// thickened sheets from outside of both.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/distance.h"
#include "bake/repair.h"
#include "formats/inside.h"
#include "formats/mesh.h"

namespace overcast {

inline constexpr const char* kTwoSided = "two-sided";  ///< Volume::signMethod where there are sheets alone

enum class SheetMode {
  automatic,  ///< the components that findSheets names
  none,       ///< nothing is a sheet: signed throughout, also where the sign is a matter of opinion
  all,        ///< everything is, solids become hollow
};

struct SheetSettings {
  SheetMode mode = SheetMode::automatic;
  double thickness = 0.0;  ///< local units; 0: leastThickness of the voxel
};

/// The diagonal of a voxel: the least thickness whose trilinear field has no hole anywhere on a sheet. At a point of the sheet the
/// interpolant of the distance is at most the weighted mean distance to the cell's corners, which is at most half of this (the root mean
/// square, sqrt(sum over axes of t (1 - t)) voxels with t the place in the cell, is largest in its middle).
double leastThickness(double voxelSize);

/// What is known of the components of a mesh without knowing the thickness.
struct SheetTable {
  std::vector<std::uint32_t> component;  ///< of every triangle
  std::vector<std::uint8_t> undecided;   ///< per component: open, and for more than half of its area the winding number beside it is more
                                         ///< than 0.2 from an integer: no side of it is inside
  std::vector<double> plateThickness;    ///< per component: of plates: twice volume over area where that is below 0.03 of the area's root;
                                         ///< infinite for all others, so that a coarse grid makes no sheet of a body
};

/// Looks at every component of a repaired mesh. Closed ones cost a pass over triangles and edges. Open ones whose boundary is short (its
/// length squared below a hundredth of the area) are decided; for the others the winding number of all open components is taken at about
/// 4,096 points of their surface, and those too small for 16 points are decided together.
SheetTable sheetTable(const Mesh& mesh);

/// For every triangle whether it belongs to a sheet; empty when none does. With `automatic` these are the undecided components, and plates:
/// closed ones whose plateThickness is below thickness / sqrt(3), a voxel at leastThickness.
std::vector<std::uint8_t> findSheets(const SheetTable& table, SheetMode mode, double thickness);

/// A mesh taken apart by findSheets. Either may have no triangle.
struct SheetParts {
  Mesh solids;
  Mesh sheets;
};

SheetParts takeApart(Mesh mesh, std::span<const std::uint8_t> isSheet);

/// The sheets' share of the area of all.
double sheetShare(const SheetParts& parts);

/// What the inside of such a field is.
Inside insideOf(const MeshDiagnosis& found, const SheetParts& parts);

/// phi of `parts` at points within the box of `grid`, in double: bake/distance.h and bake/sign.h's windingAt. One of the parts has a
/// triangle. Runs on the calling TBB arena; same result for any thread count.
std::vector<double> fieldAt(const SheetParts& parts, double thickness, const Grid& grid, std::span<const glm::dvec3> points);

}  // namespace overcast
