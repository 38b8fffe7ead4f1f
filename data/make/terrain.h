// Terrain: mountains that rise and are worn by their rivers, as the project's own heights.
#pragma once

#include <string>
#include <vector>

namespace overcast {

/// A square of heights, row by row from the north, metres.
struct Mountains {
  int side = 0;
  double spacing = 0.0;
  std::vector<double> heights;
};

/// Land that is lifted evenly and cut by stream power (Braun and Willett 2013, "A very efficient O(n), implicit and parallel method to
/// solve the stream power equation", equation 22), with rounded ridges. 129 samples along a side, 10 m apart; the border is the lowest
/// land. Additions, products and square roots of doubles alone: the same on every machine.
Mountains makeMountains();

/// As an ESRI ASCII grid, in decimetres' precision.
std::string esriGrid(const Mountains& mountains);

}  // namespace overcast
