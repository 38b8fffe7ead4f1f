// Choice table: for each of many meshes what was chosen and how it compares with a volume of 32 samples in half floats, the occluder that
// Evans 2006 (figure 11) takes for everything.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bake/choose.h"

namespace overcast {

/// One mesh of the table.
struct ChoiceRow {
  std::string source;
  std::uint64_t faces = 0;
  double diagonal = 0.0;  ///< what errors are shares of
  Score winner;
  bool withinLimits = true;
  std::optional<Score> volume;    ///< kComparedWith of the same mesh at the same points; none when it cannot be stored
  std::optional<double> seconds;  ///< that the choice took, from mesh in memory to asset in memory
};

inline const Candidate kComparedWith{Representation::volume, 32, VolumeBits::half, {}, false};

/// Errors below this share of the diagonal count as that much in ratios: a cuboid that is exact but for rounding has no ratio.
inline constexpr double kLeastError = 1e-6;

/// A Markdown table: mesh, faces, what was chosen, surfaceRms, max and p99 in percent of the diagonal, skyRmse, sign errors, bytes,
/// seconds, and winner over volume of bytes and of surfaceRms. Its last row has the sums, the geometric means of the ratios, and how many
/// meshes each representation won.
std::string choiceTable(const std::vector<ChoiceRow>& rows);

/// The same as a JSON array of rows and an object of totals: {"rows": [...], "totals": {...}}.
std::string choiceTableJson(const std::vector<ChoiceRow>& rows);

}  // namespace overcast
