// Bench: renderers of one baked scene that take turns, those of one resolution with one volume.
#pragma once

#include <map>
#include <vector>

#include "formats/image.h"
#include "runtime/report/candidate.h"
#include "runtime/report/scene_truth.h"

namespace overcast {

struct Bench {
  const Device& device;
  RuntimeScene& scene;
  const SceneTruth& truth;
  std::uint64_t frameBytes = 0;     ///< what a renderer takes that darkens nothing
  std::map<int, Candidate> fields;  ///< by resolution: they composite the volumes that candidates borrow
  std::vector<Candidate> candidates;
};

/// Makes the fields that `settings` and `further` resolutions need, and the candidates. After an Error destroyBench is still due.
Result<Done> fillBench(Bench& bench, const std::vector<SweepSetting>& settings, const std::vector<int>& further);
void destroyBench(Bench& bench);

/// Composites all volumes for the time of a reference.
Result<Done> moveFields(Bench& bench, const TruthPicture& truth);

/// What a candidate makes of a reference for whose time the fields are: channel sky, of the reference's size.
Result<Image> pictureOf(Bench& bench, Candidate& candidate, const TruthPicture& truth);
/// The same of a setting whose field there is, but whose candidate is not kept.
Result<Image> pictureOnce(Bench& bench, const SweepSetting& setting, const TruthPicture& truth);

/// Device memory that a candidate takes beyond a frame without any occlusion, its volume and apertures counted in.
std::uint64_t deviceBytes(const Bench& bench, const Candidate& candidate);

}  // namespace overcast
