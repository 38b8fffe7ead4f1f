// ErrorSum: every metric of one setting over all references of a scene.
#pragma once

#include "formats/report.h"
#include "runtime/metrics.h"
#include "runtime/report/scene_truth.h"

namespace overcast {

struct ErrorSum {
  ReportErrors worst;  ///< p95, p99, max and views so far
  double squares = 0.0;
  double errors = 0.0;
  double magnitudes = 0.0;
  double truthSquares = 0.0;  ///< of the reference's standard error
  double ssim = 0.0;          ///< sums over pictures
  double flip = 0.0;
  double pixels = 0.0;
  int pictures = 0;
  Flicker flicker;
  const ReferenceInfo* last = nullptr;
  double flickerSquares = 0.0;  ///< of cameras that are done
  double flickerCount = 0.0;
};

/// Adds a picture (channel sky). Pictures of one camera in the order of their frames; `truth` must live until errorsOf.
Result<Done> addPicture(ErrorSum& sum, const Image& picture, const TruthPicture& truth);

/// At least one picture must have been added.
ReportErrors errorsOf(const ErrorSum& sum);

}  // namespace overcast
