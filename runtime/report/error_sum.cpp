#include "runtime/report/error_sum.h"

#include <algorithm>
#include <cmath>

#include "runtime/flip.h"

namespace overcast {
namespace {

/// Starts a clip of its own where this picture does not follow on the last one.
void endClip(ErrorSum& sum) {
  sum.flickerSquares += sum.flicker.squares;
  sum.flickerCount += static_cast<double>(sum.flicker.count);
  sum.flicker = {};
}

bool follows(const ReferenceInfo& info, const ReferenceInfo* last) {
  return last != nullptr && last->camera == info.camera && last->frame + 1 == info.frame;
}

}  // namespace

Result<Done> addPicture(ErrorSum& sum, const Image& picture, const TruthPicture& truth) {
  static const std::vector<std::string> kSky{"sky"};
  const Comparison comparison{picture, truth.reference.image, kSky, truth.mask};
  const auto error = errorMetrics(comparison);
  if (!error) return error.error();
  const auto ssim = structuralSimilarity(comparison);
  if (!ssim) return ssim.error();
  const auto map = flip(comparison);
  if (!map) return map.error();
  if (!follows(truth.reference.info, sum.last)) endClip(sum);
  if (const auto added = addFrame(sum.flicker, comparison); !added) return added.error();
  sum.last = &truth.reference.info;
  const ErrorMetrics& e = error.value();
  const auto pixels = static_cast<double>(e.pixels);
  const double noise = standardError(truth.reference.image, truth.mask);
  sum.worst.views.push_back(e.rmse);
  sum.pixels += pixels;
  sum.squares += pixels * e.rmse * e.rmse;
  sum.errors += pixels * e.bias;
  sum.magnitudes += pixels * e.mae;
  sum.truthSquares += pixels * noise * noise;
  sum.worst.p95 = std::max(sum.worst.p95, e.p95);
  sum.worst.p99 = std::max(sum.worst.p99, e.p99);
  sum.worst.max = std::max(sum.worst.max, e.max);
  sum.ssim += ssim.value();
  sum.flip += map.value().mean;
  ++sum.pictures;
  return Done{};
}

ReportErrors errorsOf(const ErrorSum& sum) {
  OVERCAST_REQUIRE(sum.pictures > 0, "no pictures");
  ReportErrors errors = sum.worst;
  errors.rmse = std::sqrt(sum.squares / sum.pixels);
  errors.rmseCorrected = std::sqrt(std::max(0.0, sum.squares - sum.truthSquares) / sum.pixels);
  errors.bias = sum.errors / sum.pixels;
  errors.mae = sum.magnitudes / sum.pixels;
  errors.ssim = sum.ssim / sum.pictures;
  errors.flip = sum.flip / sum.pictures;
  const double count = sum.flickerCount + static_cast<double>(sum.flicker.count);
  if (count > 0.0) errors.flicker = std::sqrt((sum.flickerSquares + sum.flicker.squares) / count);
  return errors;
}

}  // namespace overcast
