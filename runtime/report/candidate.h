// Candidate: a renderer of a scene that follows one setting of the sweep.
#pragma once

#include "runtime/frame.h"
#include "runtime/report/sweep.h"

namespace overcast {

struct Candidate {
  SweepSetting setting;
  Lighting lighting;  ///< the scene's with this setting
  FrameRenderer renderer;
  std::uint64_t bytes = 0;  ///< device memory that the renderer took
};

/// `lender` as makeFrameRenderer takes it; null: the candidate composites for itself where it reads the volume.
Result<Candidate> makeCandidate(const Device& device, RuntimeScene& scene, const SweepSetting& setting, int width, int height,
                                const FrameRenderer* lender = nullptr);
void destroyCandidate(const Device& device, Candidate& candidate);

/// One frame, of which a candidate that borrows its volume composites nothing; the scene is as before afterwards.
Result<std::vector<PassTime>> renderCandidate(const Device& device, Candidate& candidate, RuntimeScene& scene, double time,
                                              const View& view);

}  // namespace overcast
