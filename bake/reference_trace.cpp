#include "bake/reference_trace.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>

#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "bake/light_sample.h"
#include "bake/random.h"
#include "bake/ray_scene.h"
#include "bake/sample_table.h"

namespace overcast {
namespace {

constexpr std::size_t kTables = 32;  ///< a point takes kReplicates of them
constexpr std::size_t kTile = 16;    ///< points per task
constexpr std::size_t kMostChannels = 6;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

using Sums = std::array<double, kMostChannels>;

/// One point and one replicate, ready for the rays of a table.
struct Eye {
  const TracedScene& scene;
  const TraceSettings& settings;
  const TracedSurface& surface;
  const std::vector<SeenLight>& lights;
  std::array<glm::vec3, 3> frame;  ///< about the shading normal, turned at random
  std::array<double, 4> shift;     ///< of the table's points in the square, at random
};

double wrapped(double x) {
  return x - std::floor(x);
}

/// Sixteen rays as Embree takes them.
struct Packet {
  RTCRayHit16 query;
  alignas(64) std::array<int, kRayPacket> valid;
  RTCIntersectContext context;

  Packet() {
    query = {};
    std::fill_n(query.ray.mask, kRayPacket, ~0u);
    std::fill_n(query.hit.geomID, kRayPacket, RTC_INVALID_GEOMETRY_ID);
    valid.fill(0);
    rtcInitIntersectContext(&context);
  }

  void set(std::size_t i, const glm::vec3& origin, const glm::vec3& direction, float far) {
    query.ray.org_x[i] = origin.x;
    query.ray.org_y[i] = origin.y;
    query.ray.org_z[i] = origin.z;
    query.ray.dir_x[i] = direction.x;
    query.ray.dir_y[i] = direction.y;
    query.ray.dir_z[i] = direction.z;
    query.ray.tfar[i] = far;
    valid[i] = -1;
  }

  glm::vec3 direction(std::size_t i) const { return {query.ray.dir_x[i], query.ray.dir_y[i], query.ray.dir_z[i]}; }

  void occlude(const TracedScene& scene) { rtcOccluded16(valid.data(), scene.rays->scene, &context, &query.ray); }
  /// Of the rays that are there, after occlude.
  bool isFree(std::size_t i) const { return valid[i] != 0 && query.ray.tfar[i] >= 0.0f; }
};

/// The rays of one sixteenth of a table about an eye's normal.
void fill(Packet& packet, const Eye& eye, const SampleTable& table, std::size_t first, float far) {
  RTCRay16& ray = packet.query.ray;
  const glm::vec3 a = eye.frame[0], b = eye.frame[1], c = eye.frame[2], start = eye.surface.start;
  const float *x = table.x.data() + first, *y = table.y.data() + first, *z = table.z.data() + first;
  for (std::size_t i = 0; i < kRayPacket; ++i) {
    ray.dir_x[i] = a.x * x[i] + b.x * y[i] + c.x * z[i];
    ray.dir_y[i] = a.y * x[i] + b.y * y[i] + c.y * z[i];
    ray.dir_z[i] = a.z * x[i] + b.z * y[i] + c.z * z[i];
  }
  std::fill_n(ray.org_x, kRayPacket, start.x);
  std::fill_n(ray.org_y, kRayPacket, start.y);
  std::fill_n(ray.org_z, kRayPacket, start.z);
  std::fill_n(ray.tfar, kRayPacket, far);
  packet.valid.fill(-1);
}

glm::dvec3 albedo(const TracedScene& scene, const TracedSurface& surface) {
  return glm::dvec3(scene.colour[surface.triangle]);
}

void add(Sums& sums, std::size_t first, const glm::dvec3& value) {
  for (int c = 0; c < 3; ++c) sums[first + static_cast<std::size_t>(c)] += value[c];
}

glm::dvec3 skyFrom(const TracedScene& scene, const glm::dvec3& direction) {
  return scene.skyImage != nullptr ? radianceFrom(*scene.skyImage, direction) : scene.sky;
}

/// sky, dome, ao, colour.
void traceSky(const Eye& eye, const SampleTable& table, Sums& sums) {
  const TracedScene& scene = eye.scene;
  const auto bound = static_cast<float>(eye.settings.distanceBound * scene.rays->scale);
  const glm::vec3 up(scene.up);
  Packet packet;
  const bool plain = eye.lights.empty() && scene.skyImage == nullptr;
  double bare = 0.0;  // rays that meet the plain sky
  glm::dvec3 received(0.0);
  for (std::size_t first = 0; first < table.size(); first += kRayPacket) {
    fill(packet, eye, table, first, bound > 0.0f ? bound : kInfinity);
    packet.occlude(scene);
    if (bound > 0.0f) {
      for (std::size_t i = 0; i < kRayPacket; ++i) {
        sums[2] += packet.isFree(i);
        packet.valid[i] = packet.isFree(i) ? -1 : 0;
        packet.query.ray.tfar[i] = kInfinity;
      }
      packet.occlude(scene);
    }
    for (std::size_t i = 0; i < kRayPacket; ++i) {
      if (!packet.isFree(i)) continue;
      sums[0] += 1.0;
      sums[1] += glm::dot(packet.direction(i), up) > 0.0f;
      if (plain) {
        bare += 1.0;
        continue;
      }
      const glm::dvec3 direction(packet.direction(i));
      if (!coversLight(eye.lights, direction)) received += skyFrom(scene, direction);
    }
  }
  if (!(bound > 0.0f)) sums[2] = sums[0];
  add(sums, 3, albedo(scene, eye.surface) * (received + bare * scene.sky));
}

/// Sixteen rays to one light from points with normals, weighted.
struct LightPacket {
  Packet packet;
  std::array<double, kRayPacket> cosine{};

  void set(std::size_t i, const TracedScene& scene, const TracedSurface& surface, const SeenLight& light, double u, double v) {
    const LightSample sample = sampleLight(light, u, v);
    cosine[i] = glm::dot(sample.direction, surface.normal);
    if (cosine[i] > 0.0)
      packet.set(i, surface.start, glm::vec3(sample.direction), static_cast<float>(sample.far * scene.rays->scale));
    else
      packet.valid[i] = 0;
  }
};

/// light.
void traceLight(const Eye& eye, const SampleTable& table, Sums& sums) {
  for (std::size_t l = 0; l < eye.lights.size(); ++l) {
    const SeenLight& light = eye.lights[l];
    // The golden ratio's multiples spread the lights' shifts evenly.
    const double own = 0.61803398874989485 * static_cast<double>(l);
    LightPacket rays;
    double received = 0.0;
    for (std::size_t first = 0; first < table.size(); first += kRayPacket) {
      for (std::size_t i = 0; i < kRayPacket; ++i)
        rays.set(i, eye.scene, eye.surface, light, wrapped(static_cast<double>(table.u[first + i]) + eye.shift[0] + own),
                 wrapped(static_cast<double>(table.v[first + i]) + eye.shift[1] + own));
      rays.packet.occlude(eye.scene);
      for (std::size_t i = 0; i < kRayPacket; ++i)
        if (rays.packet.isFree(i)) received += rays.cosine[i];
    }
    // Over pi: the base colour is the albedo of a diffuse surface.
    add(sums, 0, albedo(eye.scene, eye.surface) * light.radiance * (2.0 * light.height * received));
  }
}

/// Where the rays of a packet hit, and what one ray to the sky and one to each light says of the light that leaves there.
struct Bounce {
  std::array<TracedSurface, kRayPacket> hit;
  std::array<std::vector<SeenLight>, kRayPacket> lights;
  std::size_t count = 0;
  std::array<std::size_t, kRayPacket> entry{};  ///< of the table
};

void findHits(const Eye& eye, Packet& packet, std::size_t first, Bounce& bounce) {
  std::fill_n(packet.query.hit.geomID, kRayPacket, RTC_INVALID_GEOMETRY_ID);
  rtcIntersect16(packet.valid.data(), eye.scene.rays->scene, &packet.context, &packet.query);
  bounce.count = 0;
  for (std::size_t i = 0; i < kRayPacket; ++i) {
    if (packet.query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const double u = static_cast<double>(packet.query.hit.u[i]), v = static_cast<double>(packet.query.hit.v[i]);
    const TracedSurface surface =
        surfaceAt(eye.scene, {packet.query.hit.primID[i], {1.0 - u - v, u, v}}, -glm::dvec3(packet.direction(i)), false);
    bounce.hit[bounce.count] = surface;
    bounce.lights[bounce.count] = lightsAround(eye.scene, surface.position);
    bounce.entry[bounce.count++] = first + i;
  }
}

glm::dvec3 skyAtHits(const Eye& eye, const SampleTable& table, const Bounce& bounce) {
  Packet packet;
  for (std::size_t i = 0; i < bounce.count; ++i) {
    const double squared = wrapped(static_cast<double>(table.second[bounce.entry[i]]) + eye.shift[2]);
    const double turn = 2.0 * std::numbers::pi * wrapped(static_cast<double>(table.third[bounce.entry[i]]) + eye.shift[3]);
    const auto frame = frameOf(bounce.hit[i].normal, turn);
    const glm::dvec3 direction = std::sqrt(squared) * frame[0] + std::sqrt(1.0 - squared) * frame[2];
    if (!coversLight(bounce.lights[i], direction)) packet.set(i, bounce.hit[i].start, glm::vec3(direction), kInfinity);
  }
  packet.occlude(eye.scene);
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < bounce.count; ++i)
    if (packet.isFree(i)) sum += albedo(eye.scene, bounce.hit[i]) * skyFrom(eye.scene, glm::dvec3(packet.direction(i)));
  return sum;
}

glm::dvec3 lightsAtHits(const Eye& eye, const SampleTable& table, const Bounce& bounce) {
  glm::dvec3 sum(0.0);
  for (std::size_t l = 0; l < eye.scene.lights.size(); ++l) {
    const double own = 0.61803398874989485 * static_cast<double>(l);
    LightPacket rays;
    for (std::size_t i = 0; i < bounce.count; ++i)
      if (l < bounce.lights[i].size())
        rays.set(i, eye.scene, bounce.hit[i], bounce.lights[i][l],
                 wrapped(static_cast<double>(table.u[bounce.entry[i]]) + eye.shift[0] + own),
                 wrapped(static_cast<double>(table.v[bounce.entry[i]]) + eye.shift[1] + own));
    rays.packet.occlude(eye.scene);
    for (std::size_t i = 0; i < bounce.count; ++i)
      if (rays.packet.isFree(i))
        sum += albedo(eye.scene, bounce.hit[i]) * bounce.lights[i][l].radiance * (2.0 * bounce.lights[i][l].height * rays.cosine[i]);
  }
  return sum;
}

/// bounce.
void traceBounce(const Eye& eye, const SampleTable& table, Sums& sums) {
  Packet packet;
  Bounce bounce;
  glm::dvec3 sum(0.0);
  for (std::size_t first = 0; first < table.size(); first += kRayPacket) {
    fill(packet, eye, table, first, kInfinity);
    findHits(eye, packet, first, bounce);
    if (bounce.count > 0) sum += skyAtHits(eye, table, bounce) + lightsAtHits(eye, table, bounce);
  }
  add(sums, 0, albedo(eye.scene, eye.surface) * sum);
}

/// Quantities that come from the same rays.
struct Family {
  void (*trace)(const Eye&, const SampleTable&, Sums&);
  std::vector<std::pair<const char*, std::size_t>> quantities;  ///< names and channels
  std::size_t channels = 0;
  std::vector<float> sums;  ///< [(point * kReplicates + replicate) * channels + channel]
  std::uint32_t rays = 0;   ///< so far, for each replicate
  bool wanted = true;       ///< more
};

Family makeFamily(void (*trace)(const Eye&, const SampleTable&, Sums&), std::vector<std::pair<const char*, std::size_t>> quantities,
                  std::size_t points) {
  Family family{trace, std::move(quantities), 0, {}, 0, true};
  for (const auto& [name, channels] : family.quantities) family.channels += channels;
  family.sums.assign(points * kReplicates * family.channels, 0.0f);
  return family;
}

std::vector<TracedQuantity> estimates(const Family& family, std::size_t points) {
  std::vector<TracedQuantity> made;
  std::size_t offset = 0;
  const double rays = static_cast<double>(family.rays);
  for (const auto& [name, channels] : family.quantities) {
    TracedQuantity quantity{name, channels, std::vector<float>(points * channels), std::vector<float>(points)};
    quantity.samples = std::uint64_t{family.rays} * kReplicates;
    double errorSum = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < points; ++i) {
      double variance = 0.0;
      for (std::size_t c = 0; c < channels; ++c) {
        double mean = 0.0, squares = 0.0;
        const auto at = [&](std::size_t r) { return family.sums[(i * kReplicates + r) * family.channels + offset + c] / rays; };
        for (std::size_t r = 0; r < kReplicates; ++r) mean += at(r) / kReplicates;
        for (std::size_t r = 0; r < kReplicates; ++r) squares += (at(r) - mean) * (at(r) - mean);
        variance += squares / (kReplicates * (kReplicates - 1)) / static_cast<double>(channels);
        quantity.values[i * channels + c] = static_cast<float>(mean);
        sum += mean;
      }
      quantity.errors[i] = static_cast<float>(std::sqrt(variance));
      errorSum += std::sqrt(variance);
      quantity.largestError = std::max(quantity.largestError, std::sqrt(variance));
    }
    if (points > 0) {
      quantity.mean = sum / static_cast<double>(points * channels);
      quantity.meanError = errorSum / static_cast<double>(points);
    }
    made.push_back(std::move(quantity));
    offset += channels;
  }
  return made;
}

/// A run of rounds over all points.
class Run {
 public:
  Run(const TracedScene& scene, std::span<const TracedSurface> points, const TraceSettings& settings, const Progress& progress)
      : scene_(scene), points_(points), settings_(settings), progress_(progress) {
    if (settings.sky) families_.push_back(makeFamily(traceSky, {{"sky", 1}, {"dome", 1}, {"ao", 1}, {"colour", 3}}, points.size()));
    if (settings.light && !scene.lights.empty()) families_.push_back(makeFamily(traceLight, {{"light", 3}}, points.size()));
    if (settings.bounce) families_.push_back(makeFamily(traceBounce, {{"bounce", 3}}, points.size()));
    const std::uint32_t most = std::clamp(settings.samples > 0 ? settings.samples : settings.mostSamples, 1u, kMostSamples);
    while (mostRays_ * kReplicates < most) mostRays_ *= 2;
  }

  std::optional<std::vector<TracedQuantity>> run() {
    for (std::uint32_t first = 0, count = kFirstRays;; first += count, count = first) {
      const std::vector<SampleTable> tables = makeSampleTables(kTables, first, count, settings_.seed);
      for (Family& family : families_)
        if (family.wanted && !round(family, tables)) return std::nullopt;
      if (!judge()) return std::move(quantities_);
    }
  }

 private:
  bool round(Family& family, const std::vector<SampleTable>& tables) {
    const std::size_t tiles = (points_.size() + kTile - 1) / kTile, rays = tables[0].size();
    const double part = static_cast<double>(rays) / std::max(1.0, static_cast<double>(tiles));
    std::atomic<bool> stopped{false};
    std::atomic<std::size_t> done{0};
    tbb::parallel_for(std::size_t{0}, tiles, [&](std::size_t tile) {
      if (stopped) return;
      for (std::size_t i = tile * kTile; i < std::min(points_.size(), (tile + 1) * kTile); ++i) trace(family, tables, i);
      const double now = done_ + part * static_cast<double>(++done);
      if (progress_ && !progress_(std::min(now / expected_, 1.0))) stopped = true;
    });
    family.rays += static_cast<std::uint32_t>(rays);
    done_ += static_cast<double>(rays);
    return !stopped;
  }

  void trace(Family& family, const std::vector<SampleTable>& tables, std::size_t i) const {
    const TracedSurface& point = points_[i];
    const std::vector<SeenLight> lights = lightsAround(scene_, point.position);
    const auto random = [&](std::size_t n) { return uniform(settings_.seed, std::uint64_t{64} * i + n); };
    const auto offset = static_cast<std::size_t>(random(0) * kTables);
    for (std::size_t r = 0; r < kReplicates; ++r) {
      const auto frame = frameOf(point.normal, 2.0 * std::numbers::pi * random(5 * r + 1));
      const Eye eye{scene_,
                    settings_,
                    point,
                    lights,
                    {glm::vec3(frame[0]), glm::vec3(frame[1]), glm::vec3(frame[2])},
                    {random(5 * r + 2), random(5 * r + 3), random(5 * r + 4), random(5 * r + 5)}};
      Sums sums{};
      family.trace(eye, tables[(offset + r) % kTables], sums);
      for (std::size_t c = 0; c < family.channels; ++c)
        family.sums[(i * kReplicates + r) * family.channels + c] += static_cast<float>(sums[c]);
    }
  }

  /// What errors of colours are relative to: the mean of all light that is reflected, or, where that is more, what a white surface
  /// reflects under the open sky.
  double brightness() const {
    double sum = 0.0;
    for (const TracedQuantity& quantity : quantities_) sum += quantity.channels == 3 ? quantity.mean : 0.0;
    return std::max(sum, (scene_.sky.x + scene_.sky.y + scene_.sky.z) / 3.0);
  }

  /// Takes the estimates so far and says which rays are still wanted; false when none are.
  bool judge() {
    quantities_.clear();
    for (const Family& family : families_)
      for (TracedQuantity& quantity : estimates(family, points_.size())) quantities_.push_back(std::move(quantity));
    const double light = brightness();
    bool any = false;
    std::size_t q = 0;
    expected_ = done_;
    for (Family& family : families_) {
      double excess = 0.0;  // largest error over what is asked for
      for (std::size_t i = 0; i < family.quantities.size(); ++i, ++q) {
        const double asked = settings_.error * (quantities_[q].channels == 3 ? light : 1.0);
        if (quantities_[q].meanError > asked) excess = std::max(excess, asked > 0.0 ? quantities_[q].meanError / asked : 1e9);
      }
      if (settings_.samples > 0) excess = 1e9;
      family.wanted = family.wanted && excess > 1.0 && family.rays < mostRays_;
      any = any || family.wanted;
      // Randomised quasi-Monte Carlo gains about a factor of 2^(3/4) each time the rays double where visibility has edges.
      if (family.wanted)
        expected_ += std::min(static_cast<double>(mostRays_), static_cast<double>(family.rays) * std::pow(excess, 4.0 / 3.0)) -
                     static_cast<double>(family.rays);
    }
    expected_ = std::max(expected_, done_ + kFirstRays);
    return any;
  }

  const TracedScene& scene_;
  const std::span<const TracedSurface> points_;
  const TraceSettings& settings_;
  const Progress& progress_;
  std::vector<Family> families_;
  std::vector<TracedQuantity> quantities_;
  std::uint32_t mostRays_ = kFirstRays;  ///< for each replicate
  double done_ = 0.0;                    ///< rays for each point, all families together
  double expected_ = 64.0 * kFirstRays;  ///< the same at the end
};

}  // namespace

std::optional<std::vector<TracedQuantity>> traceQuantities(const TracedScene& scene, std::span<const TracedSurface> points,
                                                           const TraceSettings& settings, const Progress& progress) {
  return Run(scene, points, settings, progress).run();
}

}  // namespace overcast
