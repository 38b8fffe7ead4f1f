#include "runtime/report/error_split.h"

#include <map>

namespace overcast {
namespace {

/// 64 rays at a resolution, from what there is or rendered.
Result<const Image*> raysAt(Bench& bench, const TruthPicture& truth, const std::vector<Image>& pictures, int resolution,
                            std::map<int, Image>& rays) {
  if (const auto found = rays.find(resolution); found != rays.end()) return &found->second;
  const SweepSetting wanted = raysSetting(resolution);
  for (std::size_t i = 0; i < bench.candidates.size(); ++i)
    if (bench.candidates[i].setting.name == wanted.name) return &rays.emplace(resolution, pictures[i]).first->second;
  auto image = pictureOnce(bench, wanted, truth);
  if (!image) return image.error();
  return &rays.emplace(resolution, std::move(image).value()).first->second;
}

Result<Done> splitOne(Bench& bench, const TruthPicture& truth, std::size_t candidate, const Image& picture, const Image& finest,
                      const Image& rays, ReportRow& row) {
  SweepSetting sharp = bench.candidates[candidate].setting;
  sharp.prefilter = false;
  const bool filtered = bench.candidates[candidate].renderer.estimator.levels > 1;
  const auto unfiltered = filtered ? pictureOnce(bench, sharp, truth) : Result<Image>(picture);
  if (!unfiltered) return unfiltered.error();
  const std::vector<std::string> sky{"sky"};
  const Image* const chain[] = {&truth.reference.image, &finest, &rays, &unfiltered.value(), &picture};
  const auto steps = splitError(chain, sky, truth.mask);
  if (!steps) return steps.error();
  const char* const names[] = {"representation", "composite", "estimator", "prefilter"};
  for (std::size_t s = 0; s < steps.value().size(); ++s) {
    const ErrorStep& step = steps.value()[s];
    row.steps.push_back({names[s], step.rms, step.bias, step.share});
  }
  return Done{};
}

}  // namespace

Result<Done> splitErrors(Bench& bench, const TruthPicture& truth, const std::vector<Image>& pictures, std::vector<ReportRow>& rows) {
  std::map<int, Image> rays;
  for (std::size_t i = 0; i < bench.candidates.size(); ++i) {
    if (bench.candidates[i].setting.technique != Technique::overcast) continue;
    const auto finest = raysAt(bench, truth, pictures, kFinestVolume, rays);
    if (!finest) return finest.error();
    const auto own = raysAt(bench, truth, pictures, bench.candidates[i].setting.resolution, rays);
    if (!own) return own.error();
    const auto done = splitOne(bench, truth, i, pictures[i], *finest.value(), *own.value(), rows[i]);
    if (!done) return done;
  }
  return Done{};
}

}  // namespace overcast
