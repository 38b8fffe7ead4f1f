#include "tests/golden/compare.h"

#include <algorithm>
#include <cmath>

namespace overcast {
namespace {

constexpr int kColours = 3;
constexpr float kGain = 8.0f;

}  // namespace

Result<Difference> compare(const Image& picture, const Image& golden, double off) {
  if (picture.width != golden.width || picture.height != golden.height) {
    return Error{"", "", fmt::format("the picture is {}x{}, its golden {}x{}", picture.width, picture.height, golden.width, golden.height)};
  }
  Difference difference;
  double squares = 0.0, pixelsOff = 0.0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      double worst = 0.0;
      for (int c = 0; c < kColours; ++c) {
        const double d = std::abs(double(at(picture, x, y, c)) - double(at(golden, x, y, c)));
        squares += d * d;
        worst = std::max(worst, d);
      }
      difference.max = std::max(difference.max, worst);
      if (worst > off) pixelsOff += 1.0;
    }
  }
  const double pixels = double(picture.width) * picture.height;
  difference.rmse = std::sqrt(squares / (kColours * pixels));
  difference.share = pixelsOff / pixels;
  return difference;
}

bool within(const Difference& difference, const Tolerance& tolerance) {
  return difference.rmse <= tolerance.rmse && difference.share <= tolerance.share;
}

std::string describe(const Difference& difference, double off) {
  return fmt::format("rmse {:.5f}, max {:.3f}, {:.2f} % of the pixels off by more than {}", difference.rmse, difference.max,
                     100.0 * difference.share, off);
}

Image differenceImage(const Image& picture, const Image& golden) {
  Image image{picture.width, picture.height, {"R", "G", "B"}, {}};
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (int c = 0; c < kColours; ++c) image.pixels.push_back(kGain * std::abs(at(picture, x, y, c) - at(golden, x, y, c)));
  return image;
}

}  // namespace overcast
