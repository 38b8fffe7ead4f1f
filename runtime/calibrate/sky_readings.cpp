#include "runtime/calibrate/sky_readings.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "runtime/passes/screen/screen.h"

namespace overcast {
namespace {

/// Where in the texels of a reference its channels are.
struct Texels {
  const Image& image;
  std::size_t at(std::size_t texel, int channel) const { return texel * image.channels.size() + static_cast<std::size_t>(channel); }
  float operator()(std::size_t texel, int channel) const { return image.pixels[at(texel, channel)]; }
  glm::vec3 vector(std::size_t texel, const std::array<int, 3>& channels) const {
    return {(*this)(texel, channels[0]), (*this)(texel, channels[1]), (*this)(texel, channels[2])};
  }
  std::array<int, 3> channelsOf(const std::string& name) const {
    return {channelIndex(image, name + ".X"), channelIndex(image, name + ".Y"), channelIndex(image, name + ".Z")};
  }
};

/// Unit vector from the eye through the centre of a pixel.
glm::dvec3 rayOf(const ReferenceInfo& info, std::size_t texel) {
  const double tangent = std::tan(0.5 * info.view.verticalFieldOfView), aspect = static_cast<double>(info.width) / info.height;
  const auto width = static_cast<std::size_t>(info.width);
  const std::size_t row = texel / width;
  const double x = 2.0 * (static_cast<double>(texel % width) + 0.5) / info.width - 1.0;
  const double y = 1.0 - 2.0 * (static_cast<double>(row) + 0.5) / info.height;
  return glm::normalize(glm::dvec3(info.view.worldFromView * glm::dvec4(tangent * aspect * x, tangent * y, -1.0, 0.0)));
}

std::vector<std::size_t> surfaces(const Texels& texels, int depth) {
  std::vector<std::size_t> found;
  const auto count = static_cast<std::size_t>(texels.image.width) * static_cast<std::size_t>(texels.image.height);
  for (std::size_t texel = 0; texel < count; ++texel)
    if (texels(texel, depth) >= 0.0f) found.push_back(texel);
  return found;
}

/// What the taps of one place of the wide pattern miss, and the gaps between them.
void readPlace(const SkyField& field, const SkyEstimator& estimator, const glm::vec3& p, const glm::mat3& frame, int place,
               std::vector<float>& readings) {
  const glm::vec3 turned = shared::tracedDirection(0, 1, place), direction = frame * turned;
  const float end = shared::reachInVolume(p, direction, glm::vec3(field.levels[0].size));
  std::vector<float> gaps;
  float before = 0.0f, phiBefore = 0.0f;
  for (std::size_t tap = 0; tap < estimator.taps.size(); ++tap) {
    const float d = shared::calibratedDistance(estimator.taps[tap], place, end), phi = fieldAt(field, 0, p + d * direction);
    readings.push_back(shared::shareMissing(phi, d, turned.z));
    if (tap > 0) gaps.push_back(shared::gapMissing(phiBefore, before, phi, d, turned.z));
    before = d;
    phiBefore = phi;
  }
  readings.insert(readings.end(), gaps.begin(), gaps.end());
}

float meanOverPattern(const SkyEstimator& estimator, std::span<const float> readings) {
  const std::size_t taps = estimator.taps.size();
  float sum = 0.0f;
  for (int n = 0; n < shared::kPointPlaces; ++n) {
    std::array<glm::vec4, 2> missing{glm::vec4(0.0f), glm::vec4(0.0f)}, gaps = missing;
    const auto own = readings.subspan(static_cast<std::size_t>(n) * (2 * taps - 1));
    for (std::size_t tap = 0; tap < taps; ++tap) {
      missing[tap / 4][static_cast<int>(tap % 4)] = own[tap];
      if (tap > 0) gaps[(tap - 1) / 4][static_cast<int>((tap - 1) % 4)] = own[taps + tap - 1];
    }
    const float u = shared::tracedDirection(0, 1, shared::pointPlace(n)).z;
    float exponent = 0.0f;
    for (const shared::SkyStep& step : estimator.steps) exponent += shared::stepExponent(step, missing[0], missing[1], gaps[0], gaps[1], u);
    sum += std::exp(-std::max(exponent, 0.0f));
  }
  return sum / static_cast<float>(shared::kPointPlaces);
}

float meanOverCones(const SkyEstimator& estimator, std::span<const float> phi) {
  const std::size_t taps = estimator.taps.size();
  float sum = 0.0f;
  for (std::size_t cone = 0; cone < estimator.directions.size(); ++cone) {
    float open = 1.0f;
    for (std::size_t tap = 0; tap < taps; ++tap)
      open = std::min(open, shared::coneOpenness(phi[cone * taps + tap], estimator.taps[tap].distance, glm::vec4(estimator.cone, 0.0f)));
    sum += open;
  }
  return std::pow(sum / static_cast<float>(estimator.directions.size()), estimator.cone.z);
}

}  // namespace

std::vector<SurfacePoint> surfacePoints(const Reference& reference, std::size_t most) {
  const Texels texels{reference.image};
  const ReferenceInfo& info = reference.info;
  const int depth = channelIndex(reference.image, "depth"), sky = channelIndex(reference.image, "sky");
  const int object = channelIndex(reference.image, "object");
  const std::array<int, 3> normal = texels.channelsOf("normal"), position = texels.channelsOf("position");
  const std::vector<std::size_t> found = surfaces(texels, depth);
  const std::size_t count = std::min(most, found.size());
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t texel = found[i * found.size() / count];
    SurfacePoint& point = points.emplace_back();
    point.position = info.kind == ReferenceKind::view ? eye(info.view) + double{texels(texel, depth)} * rayOf(info, texel)
                                                      : info.origin + glm::dvec3(texels.vector(texel, position));
    point.normal = texels.vector(texel, normal);
    point.sky = texels(texel, sky);
    point.object = static_cast<int>(texels(texel, object));
  }
  return points;
}

std::size_t readingsOf(const SkyEstimator& estimator) {
  if (!estimator.steps.empty()) return shared::kPointPlaces * (2 * estimator.taps.size() - 1);
  return estimator.taps.size() * std::max<std::size_t>(1, estimator.directions.size());
}

void readTaps(const SkyField& field, const SkyEstimator& estimator, const glm::vec3& up, const SurfacePoint& point,
              std::vector<float>& readings) {
  const glm::vec3 p(voxelFromWorld(field.grid) * glm::dvec4(point.position, 1.0));
  const glm::mat3 frame = shared::frameAbout(point.normal);
  if (!estimator.steps.empty()) {
    for (int n = 0; n < shared::kPointPlaces; ++n) readPlace(field, estimator, p, frame, shared::pointPlace(n), readings);
    return;
  }
  const auto along = [&](const glm::vec3& direction) {
    for (const shared::SkyTap& tap : estimator.taps) readings.push_back(fieldAt(field, tap.level, p + tap.distance * direction));
  };
  if (estimator.directions.empty()) return along(shared::skewedNormal(point.normal, estimator.skyWeight * up));
  for (const glm::vec3& direction : estimator.directions) along(frame * direction);
}

float visibilityOf(const SkyEstimator& estimator, std::span<const float> readings) {
  if (!estimator.steps.empty()) return meanOverPattern(estimator, readings);
  if (!estimator.directions.empty()) return meanOverCones(estimator, readings);
  float exponent = 0.0f;
  for (std::size_t tap = 0; tap < estimator.taps.size(); ++tap)
    exponent += estimator.taps[tap].weight * shared::tapMissing(readings[tap], estimator.taps[tap].distance, estimator.skyWeight);
  return shared::skyVisibility(exponent);
}

}  // namespace overcast
