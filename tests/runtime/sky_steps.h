// Steps of an estimator as the reference takes them.
#pragma once

#include <vector>

#include "runtime/passes/shade/sky_estimator.h"
#include "tests/reference/sky.h"

namespace overcast::test {

inline std::vector<reference::Step> stepsOf(const SkyEstimator& estimator) {
  std::vector<reference::Step> steps;
  for (const shared::SkyStep& step : estimator.steps) {
    reference::Step& made = steps.emplace_back();
    for (int tap = 0; tap < static_cast<int>(estimator.taps.size()); ++tap)
      made.weights.push_back(tap < 4 ? step.nearWeights[tap] : step.farWeights[tap - 4]);
    for (int gap = 0; gap + 1 < static_cast<int>(estimator.taps.size()); ++gap)
      made.gaps.push_back(gap < 4 ? step.nearGaps[gap] : step.farGaps[gap - 4]);
    made.start = step.shape.x;
    made.slant = step.shape.y;
    made.height = step.shape.z;
  }
  return steps;
}

}  // namespace overcast::test
