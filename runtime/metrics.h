// Metrics: how far a picture is from its reference, on linear values, over the pixels that show surfaces. No GPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/result.h"

namespace overcast {

/// One entry per pixel, row 0 at the top: 0 where the pixel does not count.
using Mask = std::vector<std::uint8_t>;

/// The mask of a reference: pixels whose channel "depth" is not negative (formats/reference.h); every pixel where there is no such channel.
Mask surfaceMask(const Image& reference);

/// What is compared: the named channels of both, e.g. {"sky"} or {"R", "G", "B"}, where `mask` is not 0. Channels are looked up by name, so
/// that the two images may hold others besides. Every function that takes a Comparison returns an Error that says which when the images
/// differ in size, one lacks a channel, no pixel counts, or a value that counts is not finite.
struct Comparison {
  const Image& picture;
  const Image& reference;
  std::span<const std::string> channels;
  const Mask& mask;  ///< as many entries as the reference has pixels
};

/// e = picture - reference, for each pixel that counts and each channel, in the units of the channel.
struct ErrorMetrics {
  std::size_t pixels = 0;  ///< that count
  double rmse = 0.0;       ///< root of the mean of e^2
  double bias = 0.0;       ///< mean of e: above 0 where the picture is too bright
  double mae = 0.0;        ///< mean of |e|
  double p95 = 0.0;        ///< the smallest |e| that 95 % of all do not exceed
  double p99 = 0.0;
  double max = 0.0;  ///< largest |e|
};
Result<ErrorMetrics> errorMetrics(const Comparison& comparison);

/// Mean structural similarity, at most 1 (the same picture), averaged over pixels that count and channels (Z. Wang, A. Bovik, H. Sheikh,
/// E. Simoncelli, "Image Quality Assessment: From Error Visibility to Structural Similarity", 2004, eq. 13 to 17): Gaussian window of 11 x
/// 11 pixels, sigma 1.5, C1 = (0.01 L)^2, C2 = (0.03 L)^2, with L = `range` > 0, the span of values that matters. A window holds only the
/// pixels that count, its weights made to sum to 1 again: neither the background nor the border of the picture enters.
Result<double> structuralSimilarity(const Comparison& comparison, double range = 1.0);

/// Flicker of a clip: how much the error changes from one frame to the next, where a surface is seen in both. A technique that is wrong but
/// steady has none. Start with an empty one and add the frames in order.
struct Flicker {
  std::vector<float> lastErrors;  ///< of the frame before, channel by channel within each pixel
  Mask lastMask;
  double squares = 0.0;   ///< sum of (e_t - e_(t - 1))^2
  double largest = 0.0;   ///< of |e_t - e_(t - 1)|
  std::size_t count = 0;  ///< values that went into the sum
};
/// Errors as above, and when the frame has another size or other channels than the one before; `flicker` is then as it was.
Result<Done> addFrame(Flicker& flicker, const Comparison& frame);
/// Root of the mean of (e_t - e_(t - 1))^2; 0 before the second frame.
double flickerRms(const Flicker& flicker);

/// One step on the way from the truth to the picture on the screen: step = what it makes - what the one before it made.
struct ErrorStep {
  double rms = 0.0;   ///< root of the mean of step^2: what it changes by itself
  double bias = 0.0;  ///< mean of step; the steps sum to the bias of the whole
  /// Its share of the mean squared error, mean(step * e) / mean(e^2) with e the whole error. Shares sum to 1; below 0 where the step makes
  /// good what others spoil. All 0 when there is no error.
  double share = 0.0;
};

/// Splits the error of chain.back() against chain.front(), the truth, into its sources: each image between them makes one approximation
/// more than the one before it (representation, composite, prefilter, estimator). Returns chain.size() - 1 steps in order; at least 2
/// images.
Result<std::vector<ErrorStep>> splitError(std::span<const Image* const> chain, std::span<const std::string> channels, const Mask& mask);

}  // namespace overcast
