// Pareto: the front of error against bytes and against composite time, and its picture.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bake/choose.h"

namespace overcast {

/// Candidates that cost something and have an error; both axes are logarithmic.
struct ParetoPoint {
  std::size_t score = 0;  ///< index into the record's scores
  double cost = 0.0;
  double error = 0.0;
};

/// Those of `points` that no other one beats in one figure without losing in the other, by rising cost. Of equal ones the first stays.
std::vector<ParetoPoint> paretoFront(std::vector<ParetoPoint> points);

/// A mesh and what was measured of its candidates.
struct ExplainedMesh {
  std::string source;
  ChoiceRecord record;
};

/// An SVG 1.1 document: for every mesh a row of two panels, surface error in percent of the diagonal against bytes and against the time
/// of an evaluation in the composite in nanoseconds, all candidates as dots coloured by representation, the front as a line, the choice
/// ringed. Candidates without a measurement are left out.
std::string paretoSvg(const std::vector<ExplainedMesh>& meshes);

}  // namespace overcast
