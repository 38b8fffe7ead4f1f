#include "bake/reference.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "bake/ray_scene.h"

namespace overcast {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kPointsWidth = 1024;

/// What is known before light is traced: surfaces, and the pixel of each.
struct Surfaces {
  std::vector<TracedSurface> surfaces;
  std::vector<std::size_t> pixels;
  std::vector<float> depths;
};

Surfaces surfacesSeen(const TracedScene& scene, const ReferenceView& asked) {
  const auto width = static_cast<std::size_t>(asked.width), height = static_cast<std::size_t>(asked.height);
  const glm::dmat3 axes(asked.view.worldFromView);
  const double tangentY = std::tan(0.5 * asked.view.verticalFieldOfView), tangentX = tangentY * asked.width / asked.height;
  std::vector<std::optional<TracedHit>> hits(width * height);
  tbb::parallel_for(std::size_t{0}, height, [&](std::size_t y) {
    for (std::size_t x = 0; x < width; ++x) {
      const double right = (2.0 * static_cast<double>(x) + 1.0) / asked.width - 1.0;
      const double down = (2.0 * static_cast<double>(y) + 1.0) / asked.height - 1.0;
      const glm::dvec3 along(right * tangentX, -down * tangentY, -1.0);
      const double length = glm::length(along);
      hits[y * width + x] = firstHit(scene, eye(asked.view), axes * (along / length), asked.view.nearPlane * length);
    }
  });
  Surfaces seen;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i]) continue;
    seen.surfaces.push_back(hits[i]->surface);
    seen.pixels.push_back(i);
    seen.depths.push_back(static_cast<float>(hits[i]->distance));
  }
  return seen;
}

/// Points that lie outside of solids, at most `count`.
Surfaces surfacePoints(const TracedScene& scene, std::uint64_t count, std::uint64_t seed) {
  constexpr std::uint64_t kDraws = 8;
  Surfaces points;
  for (std::uint64_t draw = 0; draw < kDraws && points.surfaces.size() < count; ++draw) {
    const std::vector<SurfaceSample> samples = sampleSurface(scene.mesh, count, seed + (draw << 32));
    std::vector<TracedSurface> drawn(samples.size());
    std::vector<char> inside(samples.size());
    tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
      const glm::uvec3& t = scene.mesh.triangles[samples[i].triangle];
      const auto edge = [&](std::uint32_t corner) {
        return (scene.mesh.positions[corner] - scene.mesh.positions[t.x]) * scene.rays->scale;
      };
      drawn[i] = surfaceAt(scene, samples[i], glm::cross(edge(t.y), edge(t.z)));
      inside[i] = liesInside(scene, drawn[i]);
    });
    for (std::size_t i = 0; i < drawn.size() && points.surfaces.size() < count; ++i)
      if (!inside[i]) points.surfaces.push_back(drawn[i]);
  }
  points.depths.assign(points.surfaces.size(), 0.0f);
  for (std::size_t i = 0; i < points.surfaces.size(); ++i) points.pixels.push_back(i);
  return points;
}

void addChannels(Image& image, std::vector<std::string> names) {
  image.channels.insert(image.channels.end(), std::make_move_iterator(names.begin()), std::make_move_iterator(names.end()));
}

std::vector<std::string> channelsOf(const TracedQuantity& quantity) {
  if (quantity.channels == 1) return {quantity.name};
  const std::string layer = quantity.name == "colour" ? "" : quantity.name + ".";
  return {layer + "R", layer + "G", layer + "B"};
}

/// Puts everything into the reference; its size and kind are set.
void fill(Reference& reference, const TracedScene& scene, const Surfaces& seen, const std::vector<TracedQuantity>& quantities) {
  Image& image = reference.image;
  const bool points = reference.info.kind == ReferenceKind::points;
  image.width = reference.info.width;
  image.height = reference.info.height;
  image.channels = {"depth", "normal.X", "normal.Y", "normal.Z", "object"};
  if (points) addChannels(image, {"position.X", "position.Y", "position.Z"});
  for (const TracedQuantity& quantity : quantities) {
    addChannels(image, channelsOf(quantity));
    addChannels(image, {quantity.name + ".error"});
  }
  const std::size_t width = image.channels.size();
  image.pixels.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * width, 0.0f);
  for (std::size_t pixel = 0; pixel < image.pixels.size(); pixel += width) image.pixels[pixel] = image.pixels[pixel + 4] = -1.0f;
  for (std::size_t i = 0; i < seen.surfaces.size(); ++i) {
    const TracedSurface& surface = seen.surfaces[i];
    float* value = &image.pixels[seen.pixels[i] * width];
    *value++ = seen.depths[i];
    for (int axis = 0; axis < 3; ++axis) *value++ = static_cast<float>(surface.normal[axis]);
    *value++ = static_cast<float>(scene.node[surface.triangle]);
    for (int axis = 0; points && axis < 3; ++axis) *value++ = static_cast<float>(surface.position[axis] - reference.info.origin[axis]);
    for (const TracedQuantity& quantity : quantities) {
      value = std::copy_n(&quantity.values[i * quantity.channels], quantity.channels, value);
      *value++ = quantity.errors[i];
    }
  }
}

/// Traces the light at the surfaces into the reference.
std::optional<Reference> finish(Reference reference, const TracedScene& scene, const Surfaces& seen, const TraceSettings& settings,
                                Clock::time_point start, const Progress& progress) {
  const auto quantities = traceQuantities(scene, seen.surfaces, settings, progress);
  if (!quantities) return std::nullopt;
  fill(reference, scene, seen, *quantities);
  ReferenceInfo& info = reference.info;
  info.distanceBound = settings.distanceBound;
  info.targetError = settings.samples > 0 ? 0.0 : settings.error;
  info.seed = settings.seed;
  for (const TracedQuantity& q : *quantities) info.quantities.push_back({q.name, q.samples, q.mean, q.meanError, q.largestError});
  info.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return reference;
}

}  // namespace

std::optional<Reference> traceView(const TracedScene& scene, const ReferenceView& view, const TraceSettings& settings,
                                   const Progress& progress) {
  const auto start = Clock::now();
  Reference reference;
  reference.info.kind = ReferenceKind::view;
  reference.info.width = view.width;
  reference.info.height = view.height;
  reference.info.view = view.view;
  return finish(std::move(reference), scene, surfacesSeen(scene, view), settings, start, progress);
}

std::optional<Reference> tracePoints(const TracedScene& scene, std::uint64_t count, const TraceSettings& settings,
                                     const Progress& progress) {
  const auto start = Clock::now();
  const Surfaces points = surfacePoints(scene, count, settings.seed);
  Reference reference;
  reference.info.kind = ReferenceKind::points;
  reference.info.points = points.surfaces.size();
  const std::uint64_t width = std::clamp<std::uint64_t>(reference.info.points, 1, kPointsWidth);
  reference.info.width = static_cast<int>(width);
  reference.info.height = static_cast<int>(std::max<std::uint64_t>(1, (reference.info.points + width - 1) / width));
  reference.info.origin = centre(bounds(scene.mesh));
  return finish(std::move(reference), scene, points, settings, start, progress);
}

std::string settingsText(const TraceSettings& settings) {
  return fmt::format("{} {} {} {} {} {} {} {}", settings.sky, settings.light, settings.bounce, settings.distanceBound, settings.error,
                     settings.samples, settings.mostSamples, settings.seed);
}

Image previewOf(const Reference& reference, double exposure) {
  const Image& source = reference.image;
  const auto value = [&](int x, int y, const std::string& channel) {
    const int index = channelIndex(source, channel);
    return index < 0 ? 0.0 : static_cast<double>(at(source, x, y, index));
  };
  Image picture{3 * source.width, source.height, {"R", "G", "B"}, {}};
  picture.pixels.resize(std::size_t{3} * 3 * static_cast<std::size_t>(source.width) * static_cast<std::size_t>(source.height));
  const auto encoded = [](double linear) { return static_cast<float>(std::pow(std::clamp(linear, 0.0, 1.0), 1.0 / 2.2)); };
  for (int y = 0; y < source.height; ++y)
    for (int x = 0; x < source.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const std::string colour(1, "RGB"[c]);
        const double light = value(x, y, colour) + value(x, y, "light." + colour) + value(x, y, "bounce." + colour);
        at(picture, x, y, c) = encoded(value(x, y, "sky"));
        at(picture, source.width + x, y, c) = encoded(value(x, y, "ao"));
        at(picture, 2 * source.width + x, y, c) = encoded(exposure * light);
      }
  return picture;
}

}  // namespace overcast
