#include "formats/view_options.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <regex>
#include <vector>

#include <fmt/format.h>

#include "formats/image.h"

namespace overcast {
namespace {

constexpr int kMaxFrame = 9999999;

Result<std::vector<double>> numbers(const std::string& text) {
  std::vector<double> values;
  std::size_t at = 0;
  while (at <= text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string word = text.substr(at, comma - at);
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0' || !std::isfinite(value)) return Error{"", "", fmt::format("'{}' is not a number", word)};
    values.push_back(value);
    at = comma + 1;
  }
  return values;
}

/// Two whole numbers of at most 7 digits with `between` between them.
std::optional<std::pair<int, int>> twoNumbers(const std::string& text, char between) {
  static const std::regex kNumbers("([0-9]{1,7})([:x])([0-9]{1,7})");
  std::smatch match;
  if (!std::regex_match(text, match, kNumbers) || match[2].str()[0] != between) return std::nullopt;
  return std::pair(std::stoi(match[1]), std::stoi(match[3]));
}

}  // namespace

Result<std::pair<int, int>> parseFrames(const std::string& text) {
  const auto range = text.find(':') == std::string::npos ? twoNumbers(text + ":" + text, ':') : twoNumbers(text, ':');
  if (!range || range->first > range->second || range->second > kMaxFrame)
    return Error{"", "", fmt::format("'{}' is not first:last with 0 <= first <= last", text)};
  return *range;
}

Result<std::pair<int, int>> parseSize(const std::string& text) {
  const auto size = twoNumbers(text, 'x');
  if (!size || size->first < 1 || size->second < 1 || size->first > kMaxImageSide || size->second > kMaxImageSide)
    return Error{"", "", fmt::format("'{}' is not WIDTHxHEIGHT, each from 1 to {}", text, kMaxImageSide)};
  return *size;
}

Result<CameraOption> parseCamera(const std::string& text) {
  const Result<std::vector<double>> parsed = numbers(text);
  if (!parsed) return parsed.error();
  const std::vector<double>& n = parsed.value();
  if (n.size() != 6 && n.size() != 7) return Error{"", "", fmt::format("{} numbers instead of px,py,pz,tx,ty,tz[,fov]", n.size())};
  CameraOption camera;
  camera.eye = {n[0], n[1], n[2]};
  camera.target = {n[3], n[4], n[5]};
  if (camera.eye == camera.target) return Error{"", "", "eye and target are the same point"};
  if (n.size() == 6) return camera;
  if (n[6] < 1.0 || n[6] > 170.0) return Error{"", "", fmt::format("a field of view of {} degrees is outside 1 to 170", n[6])};
  camera.verticalFieldOfView = n[6] * std::numbers::pi / 180.0;
  return camera;
}

View chooseView(const Scene& scene, const Box& bounds, const std::optional<CameraOption>& camera, double time, double aspect) {
  const glm::dvec3 up(0.0, 1.0, 0.0);
  if (camera) return lookAt(camera->eye, camera->target, up, camera->verticalFieldOfView);
  const std::optional<View> own = sceneView(scene, worldFromLocal(scene, time));
  return own ? *own : frameBox(bounds, up, aspect);
}

}  // namespace overcast
