// Picture: what a page shows of the measured pictures.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/image.h"
#include "runtime/report/measure_scene.h"

namespace overcast {

inline constexpr double kDifferenceRange = 0.25;  ///< a difference of sky visibility that has its full colour

/// Sky visibility as grey (display-encoded); what does not count is a plain light blue.
Image skyPicture(const Image& sky, const Mask& mask);

/// picture - reference: white where they agree, red where it is too bright, blue where it is too dark, in full colour at kDifferenceRange.
Image differencePicture(const Image& sky, const Image& reference, const Mask& mask);

/// A picture of a page, as what an <img> takes.
struct PagePicture {
  std::string picture;  ///< data:image/png;base64,...
};

/// The rows whose difference from the reference is also written: the scene's own setting, our best, and the best of every other technique;
/// indices in their order.
std::vector<std::size_t> shownRows(const ReportScene& scene);

/// Writes the reference and the pictures of all rows into `folder` as <scene>_<number>.png, the differences of the shown ones beside them,
/// and returns all but the differences for the page, the reference first. An Error when a file cannot be written.
Result<std::vector<PagePicture>> writePictures(const std::filesystem::path& folder, const MeasuredScene& measured);

std::string base64(const std::vector<std::byte>& bytes);

}  // namespace overcast
