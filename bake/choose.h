// Choose: which representation and size of a mesh to keep, by measured error. Every candidate is baked, taken as a runtime reads it
// back from disk, and measured; what lost and why is kept beside what won.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/measure.h"
#include "bake/progress.h"
#include "formats/asset.h"
#include "formats/composite_costs.h"

namespace overcast {

inline constexpr double kDefaultMaxError = 0.01;  ///< share of the mesh's diagonal
/// Of MeasuredError::skyRmse. What the best estimator of the sky from a distance volume is off the ray-traced truth by (DESIGN 5.4: hybrid,
/// 4 x 4 taps, 0.040): a substitution that changes less is not what one sees. Volumes of any size stay below 0.015; shapes that are no
/// heights and no star, seen as such, and walls that are not there come to 0.05 and more.
inline constexpr double kDefaultMaxSkyError = 0.04;
/// Share of the points measured that may lie clearly on the wrong side of the surface: 0.3 % is edges and tips of the size of the error
/// allowed lost, 1 % holes or whole parts.
inline constexpr double kMaxSignErrors = 0.001;
inline constexpr int kLargestCandidate = 256;

/// Something that may represent a mesh.
struct Candidate {
  Representation representation = Representation::volume;
  int size = 0;                             ///< samples along the longest side, or texels along a side; 0 for a primitive
  VolumeBits bits = VolumeBits::automatic;  ///< of a volume: snorm8, half or single
  std::optional<PrimitiveShape> shape;      ///< of a primitive
  bool otherSide = false;                   ///< a heightfield seen from behind an open mesh
};

/// "volume 32 half", "primitive cuboid".
std::string name(const Candidate& candidate);

/// What is known of a candidate after choosing.
struct Score {
  Candidate candidate;
  std::uint64_t bytes = 0;  ///< on disk; 0 when there is none
  MeasuredError error;      ///< of fewer samples where that already ruled it out; samples is 0 when not measured
  double composite = 0.0;   ///< nanoseconds of one evaluation in the composite, by ChoiceSettings::costs
  std::string reason;       ///< why it was not chosen, or that it was
  double thickened = 0.0;   ///< root mean square over the surface of what its voxels push sheets outward by, unless a thickness was given
};

struct ChoiceSettings {
  std::optional<Representation> only;  ///< no other representation
  std::optional<double> maxError;      ///< of surfaceRms, share of the mesh's diagonal; default kDefaultMaxError unless maxBytes is given
  double maxSkyError = kDefaultMaxSkyError;
  std::optional<std::uint64_t> maxBytes;
  int largest = kLargestCandidate;  ///< no larger sizes
  double padding = 2.0;             ///< of volumes, VolumeSettings::padding
  SheetSettings sheets;             ///< of volumes
  MeasureSettings measure;
  CompositeCosts costs = defaultCompositeCosts();  ///< of the device that the choice is for
  bool everything = false;                         ///< bake and measure every candidate up to `largest` in full: for reports
};

/// Who won and who lost, in the order of the table of candidates.
struct ChoiceRecord {
  std::vector<Score> scores;
  std::size_t chosen = 0;  ///< index into scores
  double diagonal = 0.0;   ///< of the mesh's box: what maxError is a share of
  bool withinLimits = true;
};

/// The winner as stored, and the record.
struct Choice {
  Asset asset;
  ChoiceRecord record;
  std::shared_ptr<const PreparedMesh> prepared;  ///< as it was measured
  MeshDiagnosis found;
  double ambiguousSign = 0.0;  ///< Probes::ambiguousSign
};

/// Bytes of two representations are the same when neither is more than this share above the other: sizes come in steps of four times the
/// samples, so that less says nothing about the shapes.
inline constexpr double kSameBytes = 0.5;

/// Bakes candidates of rising size and keeps the one of fewest bytes on disk (of two representations within kSameBytes the one further
/// within the limits, then the one that is cheaper to composite) whose surfaceRms and thickened are within maxError, skyRmse within
/// maxSkyError, share of sign errors within kMaxSignErrors and bytes within maxBytes. When none is within all, or only maxBytes is given:
/// the one of least surfaceRms within maxBytes (or within nothing where there is no maxBytes), those that keep to sky and sign before those
/// that do not; then withinLimits is false if a limit was missed. An open mesh has no inside: a heightfield is tried from the side that its
/// triangles face, and from the other where nothing from there is within the limits. Sizes of a representation are not tried beyond the
/// first that meets the limits, nor beyond two that came no nearer to them than the size before each, nor beyond what already costs more
/// than a candidate that does; candidates are measured with an eighth of the samples first, and no further when that is over twice a limit.
/// A winner with sign errors has its count in the record and in every report. Deterministic. An Error when no candidate can represent the
/// mesh or fits maxBytes, or `progress` asked to stop
/// ("interrupted").
Result<Choice> choose(const Mesh& mesh, const ChoiceSettings& settings, const Progress& progress = {});

/// One candidate, baked, stored and measured in full, whatever its error. An Error when it cannot represent the mesh or be stored.
Result<Score> scoreOf(const Mesh& mesh, const Candidate& candidate, const ChoiceSettings& settings);

}  // namespace overcast
