#include "runtime/report/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "formats/files.h"
#include "runtime/technique.h"

namespace overcast {
namespace {

using Colour = std::array<float, 3>;
constexpr Colour kNothing{0.87f, 0.91f, 0.95f};

float encoded(float linear) {
  const float x = std::clamp(linear, 0.0f, 1.0f);
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

template <class ColourOf>
Image painted(const Image& sky, const Mask& mask, const ColourOf& colourOf) {
  Image image{sky.width, sky.height, {"R", "G", "B"}, {}};
  for (std::size_t pixel = 0; pixel < mask.size(); ++pixel) {
    const Colour colour = mask[pixel] != 0 ? colourOf(pixel) : kNothing;
    image.pixels.insert(image.pixels.end(), colour.begin(), colour.end());
  }
  return image;
}

float skyAt(const Image& image, std::size_t pixel) {
  return image.pixels[pixel * image.channels.size() + static_cast<std::size_t>(channelIndex(image, "sky"))];
}

Result<std::string> written(const std::filesystem::path& file, const Image& image) {
  if (const auto done = writePng(file, image); !done) return done.error();
  const auto bytes = readFile(file);
  if (!bytes) return bytes.error();
  return "data:image/png;base64," + base64(bytes.value());
}

}  // namespace

Image skyPicture(const Image& sky, const Mask& mask) {
  return painted(sky, mask, [&](std::size_t pixel) {
    const float grey = encoded(skyAt(sky, pixel));
    return Colour{grey, grey, grey};
  });
}

Image differencePicture(const Image& sky, const Image& reference, const Mask& mask) {
  return painted(sky, mask, [&](std::size_t pixel) {
    const float error = (skyAt(sky, pixel) - skyAt(reference, pixel)) / static_cast<float>(kDifferenceRange);
    const float t = std::min(std::abs(error), 1.0f);
    const Colour full = error > 0.0f ? Colour{0.78f, 0.05f, 0.08f} : Colour{0.05f, 0.22f, 0.72f};
    return Colour{1.0f + t * (full[0] - 1.0f), 1.0f + t * (full[1] - 1.0f), 1.0f + t * (full[2] - 1.0f)};
  });
}

std::vector<std::size_t> shownRows(const ReportScene& scene) {
  std::map<std::string, std::size_t> best;
  for (std::size_t i = 0; i < scene.rows.size(); ++i) {
    const auto [entry, fresh] = best.emplace(scene.rows[i].technique, i);
    if (!fresh && scene.rows[i].errors.rmse < scene.rows[entry->second].errors.rmse) entry->second = i;
  }
  std::vector<std::size_t> rows;
  if (!scene.rows.empty()) rows.push_back(0);
  for (const auto& [technique, row] : best) rows.push_back(row);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

Result<std::vector<PagePicture>> writePictures(const std::filesystem::path& folder, const MeasuredScene& measured) {
  const Image& truth = measured.truth.pictures.back().reference.image;
  const Mask& mask = measured.truth.pictures.back().mask;
  const auto file = [&](const std::string& what) { return folder / fmt::format("{}_{}.png", measured.scene.name, what); };
  const auto reference = written(file("reference"), skyPicture(truth, mask));
  if (!reference) return reference.error();
  std::vector<PagePicture> pictures{{reference.value()}};
  const std::vector<std::size_t> shown = shownRows(measured.scene);
  for (std::size_t row = 0; row < measured.pictures.size(); ++row) {
    const Image& image = measured.pictures[row].image;
    const auto picture = written(file(fmt::format("{}", row)), skyPicture(image, mask));
    if (!picture) return picture.error();
    pictures.push_back({picture.value()});
    if (std::find(shown.begin(), shown.end(), row) == shown.end()) continue;
    const auto difference = writePng(file(fmt::format("{}_difference", row)), differencePicture(image, truth, mask));
    if (!difference) return difference.error();
  }
  return pictures;
}

std::string base64(const std::vector<std::byte>& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < count ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[bits >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

}  // namespace overcast
