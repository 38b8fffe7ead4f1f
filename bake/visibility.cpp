#include "bake/visibility.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include <embree3/rtcore.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <glm/geometric.hpp>

#include "bake/random.h"
#include "bake/ray_scene.h"

// One copy of a function per instruction set, chosen at run time; without fused multiply-add they give the same bits. Not under
// sanitizers, which are not set up when the choice is made.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define OVERCAST_VISIBILITY_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define OVERCAST_VISIBILITY_CLONES
#endif

namespace overcast {

namespace {

constexpr std::size_t kTile = 16;      // points per task, neighbours
constexpr std::size_t kBatch = 4096;   // rays per call of Embree: they and their answers stay in the cache
constexpr int kProbes = 64;            // rays that tell inside from outside
constexpr float kBeside = 1e-5f;       // radians between a ray and the one that is sent beside it
constexpr double kFew = 1.0 / 128.0;   // share of rays: a point that sees less, or through one ray, is looked at twice
constexpr std::uint64_t kSeed = 2006;  // of the azimuths

/// Moments of a set of rays. With l the direction in the frame of the normal (z up): sums of 1, l, z l, and z l l^T. Filled up to whole
/// registers.
enum Moment : std::size_t { kOne, kX, kY, kZ, kZX, kZY, kZZ, kZXX, kZXY, kZXZ, kZYY, kZYZ, kZZZ, kMoments = 16 };

using Moments = std::array<double, kMoments>;

/// Means of the moments over the whole hemisphere in closed form.
constexpr Moments kWhole = {1.0, 0.0, 0.0, 0.5, 0.0, 0.0, 1.0 / 3.0, 0.125, 0.0, 0.0, 0.125, 0.0, 0.25};

/// The rays every point sends, in the frame of its normal.
struct Table {
  std::vector<float> x, y, z;
  std::vector<Moments> moments;  ///< of each ray
  Moments all{};                 ///< of all of them
  std::size_t size() const { return x.size(); }
};

Moments momentsOf(const glm::dvec3& d) {
  const double zx = d.z * d.x, zy = d.z * d.y, zz = d.z * d.z;
  return {1.0, d.x, d.y, d.z, zx, zy, zz, zx * d.x, zx * d.y, zx * d.z, zy * d.y, zy * d.z, zz * d.z};
}

Table makeTable(int rays) {
  Table table;
  for (const glm::dvec3& d : hemisphereDirections(rays)) {
    table.x.push_back(static_cast<float>(d.x));
    table.y.push_back(static_cast<float>(d.y));
    table.z.push_back(static_cast<float>(d.z));
    table.moments.push_back(momentsOf(d));
    for (std::size_t m = 0; m < kMoments; ++m) table.all[m] += table.moments.back()[m];
  }
  return table;
}

/// Splits at the median of the longer side until a packet is left: sixteen neighbours that share their way through the tree.
void sortIntoPackets(std::span<glm::dvec3> directions) {
  if (directions.size() <= kRayPacket) return;
  glm::dvec3 low = directions[0], high = directions[0];
  for (const glm::dvec3& d : directions) {
    low = glm::min(low, d);
    high = glm::max(high, d);
  }
  const int axis = high.x - low.x >= high.y - low.y ? 0 : 1;
  const std::size_t half = (directions.size() / kRayPacket + 1) / 2 * kRayPacket;
  // Ties by the other axis: no two directions are equal, so the order is the same with every library.
  const auto before = [axis](const glm::dvec3& a, const glm::dvec3& b) {
    return a[axis] != b[axis] ? a[axis] < b[axis] : a[1 - axis] < b[1 - axis];
  };
  std::sort(directions.begin(), directions.end(), before);
  sortIntoPackets(directions.first(half));
  sortIntoPackets(directions.subspan(half));
}

/// Where a point's rays start and how they are turned, in units of the scene.
struct Eye {
  glm::vec3 start;
  std::array<glm::vec3, 3> frame;
};

Eye eyeOf(const RayScene& scene, const SurfacePoint& point, std::uint64_t index) {
  const glm::dvec3 normal(point.normal);
  const std::array<glm::dvec3, 3> frame = frameOf(normal, azimuthOf(index));
  return {glm::vec3((point.position - scene.centre) * scene.scale + kRayOffset * normal),
          {glm::vec3(frame[0]), glm::vec3(frame[1]), glm::vec3(frame[2])}};
}

/// Rays side by side as Embree's streams take them: whole points one after the other, or a part of one point's.
struct Batch {
  std::vector<float> floats;    ///< six of the ray, tfar, and zeros for tnear and time
  std::vector<unsigned> masks;  ///< all ones
  std::vector<unsigned> ids;    ///< Embree wants them; unused

  Batch() : floats(8 * kBatch), masks(kBatch, ~0u), ids(kBatch) {}
  float* column(std::size_t i) { return floats.data() + i * kBatch; }
};

RTCRayNp raysOf(Batch& batch) {
  RTCRayNp rays{};
  rays.org_x = batch.column(0);
  rays.org_y = batch.column(1);
  rays.org_z = batch.column(2);
  rays.dir_x = batch.column(3);
  rays.dir_y = batch.column(4);
  rays.dir_z = batch.column(5);
  rays.tfar = batch.column(6);
  rays.tnear = rays.time = batch.column(7);
  rays.mask = batch.masks.data();
  rays.id = rays.flags = batch.ids.data();
  return rays;
}

/// Rows `first` .. `first + count` of the table, sent from `eye`, in place of rays `to` of the batch and on. Rays that have ended stay so.
OVERCAST_VISIBILITY_CLONES void turnRays(const RTCRayNp& rays, std::size_t to, const Eye& eye, const Table& table, std::size_t first,
                                         std::size_t count) {
  const float *tableX = table.x.data() + first, *tableY = table.y.data() + first, *tableZ = table.z.data() + first;
  const glm::vec3 a = eye.frame[0], b = eye.frame[1], c = eye.frame[2];
  float *dx = rays.dir_x + to, *dy = rays.dir_y + to, *dz = rays.dir_z + to;
  for (std::size_t i = 0; i < count; ++i) dx[i] = a.x * tableX[i] + b.x * tableY[i] + c.x * tableZ[i];
  for (std::size_t i = 0; i < count; ++i) dy[i] = a.y * tableX[i] + b.y * tableY[i] + c.y * tableZ[i];
  for (std::size_t i = 0; i < count; ++i) dz[i] = a.z * tableX[i] + b.z * tableY[i] + c.z * tableZ[i];
  std::fill_n(rays.org_x + to, count, eye.start.x);
  std::fill_n(rays.org_y + to, count, eye.start.y);
  std::fill_n(rays.org_z + to, count, eye.start.z);
}

/// Adds the moments of the rays that hit something, `count` from place `from` of the batch on, which are the rows from `first` on.
OVERCAST_VISIBILITY_CLONES void addHidden(const RTCRayNp& rays, std::size_t from, const Table& table, std::size_t first, std::size_t count,
                                          Moments& hidden) {
  Moments sum = hidden;
  for (std::size_t i = 0; i < count; ++i) {
    if (rays.tfar[from + i] >= 0.0f) continue;
    const Moments& moments = table.moments[first + i];
    for (std::size_t m = 0; m < kMoments; ++m) sum[m] += moments[m];
  }
  hidden = sum;
}

/// Ends the rays that hit something. Those that have ended are passed over.
void trace(const Occluders& occluders, const RTCRayNp& rays, std::size_t count) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccludedNp(occluders.self->scene, &context, &rays, static_cast<unsigned>(count));
  if (occluders.others != nullptr) rtcOccludedNp(occluders.others->scene, &context, &rays, static_cast<unsigned>(count));
}

/// Sums over the rays of each eye that hit something.
void traceHidden(const Occluders& occluders, std::span<const Eye> eyes, const Table& table, Batch& batch, std::span<Moments> hidden) {
  const RTCRayNp rays = raysOf(batch);
  const std::size_t part = std::min(table.size(), kBatch);  // of one eye's rays
  const std::size_t together = kBatch / part;               // eyes in a batch
  for (std::size_t e = 0; e < eyes.size(); e += together) {
    const std::size_t count = std::min(together, eyes.size() - e);
    for (std::size_t first = 0; first < table.size(); first += part) {
      const std::size_t rows = std::min(part, table.size() - first);
      for (std::size_t k = 0; k < count; ++k) turnRays(rays, k * rows, eyes[e + k], table, first, rows);
      std::fill_n(rays.tfar, count * rows, std::numeric_limits<float>::infinity());
      trace(occluders, rays, count * rows);
      for (std::size_t k = 0; k < count; ++k) addHidden(rays, k * rows, table, first, rows, hidden[e + k]);
    }
  }
}

Eye besideOf(const Eye& eye) {
  const glm::vec3 axis = kBeside * (eye.frame[0] + eye.frame[1] + eye.frame[2]);
  Eye beside = eye;
  for (glm::vec3& column : beside.frame) column += glm::cross(axis, column);
  return beside;
}

/// The same for one eye, where a ray is free only when one beside it is too. Embree's fast triangle test lets single rays through exactly
/// between triangles: among many free ones that is nothing, but a point in a sealed room must see no sky at all.
Moments traceTwice(const Occluders& occluders, const Eye& eye, const Table& table, Batch& batch) {
  const RTCRayNp rays = raysOf(batch);
  const Eye beside = besideOf(eye);
  Moments hidden{};
  for (std::size_t first = 0; first < table.size(); first += kBatch) {
    const std::size_t rows = std::min(kBatch, table.size() - first);
    std::fill_n(rays.tfar, rows, std::numeric_limits<float>::infinity());
    for (const Eye& from : {eye, beside}) {
      turnRays(rays, 0, from, table, first, rows);
      trace(occluders, rays, rows);
    }
    addHidden(rays, 0, table, first, rows, hidden);
  }
  return hidden;
}

/// Whether an eye sees something, but next to nothing.
bool seesFew(const Moments& hidden, const Table& table) {
  const double free = static_cast<double>(table.size()) - hidden[kOne];
  return free > 0.0 && free <= std::max(1.0, kFew * static_cast<double>(table.size()));
}

/// Whether the ray's direction and the outer normal of what it hit point the same way.
bool meetsBack(const RTCRayHit16& hits, std::size_t i, const Surroundings* others) {
  if (hits.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) return false;
  glm::vec3 direction(hits.ray.dir_x[i], hits.ray.dir_y[i], hits.ray.dir_z[i]);
  if (hits.hit.instID[0][i] != RTC_INVALID_GEOMETRY_ID) direction = others->thereFromHere[hits.hit.instID[0][i]] * direction;
  return glm::dot(glm::vec3(hits.hit.Ng_x[i], hits.hit.Ng_y[i], hits.hit.Ng_z[i]), direction) > 0.0f;
}

/// Whether most of the probing rays first meet the back of a triangle. As soon as nearly all or nearly none of those sent do, no more are.
bool isInterior(const Occluders& occluders, const Eye& eye, const Table& probes) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  alignas(64) std::array<int, kRayPacket> valid;
  valid.fill(-1);
  std::size_t backs = 0;
  for (std::size_t first = 0; first < probes.size(); first += kRayPacket) {
    RTCRayHit16 hits{};
    for (std::size_t i = 0; i < kRayPacket; ++i) {
      const std::size_t row = first / kRayPacket + i * probes.size() / kRayPacket;  // each packet over the whole hemisphere
      const glm::vec3 d = eye.frame[0] * probes.x[row] + eye.frame[1] * probes.y[row] + eye.frame[2] * probes.z[row];
      hits.ray.org_x[i] = eye.start.x;
      hits.ray.org_y[i] = eye.start.y;
      hits.ray.org_z[i] = eye.start.z;
      hits.ray.dir_x[i] = d.x;
      hits.ray.dir_y[i] = d.y;
      hits.ray.dir_z[i] = d.z;
      hits.ray.tfar[i] = std::numeric_limits<float>::infinity();
      hits.ray.mask[i] = ~0u;
      hits.hit.geomID[i] = hits.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid.data(), occluders.self->scene, &context, &hits);
    if (occluders.others != nullptr) rtcIntersect16(valid.data(), occluders.others->scene, &context, &hits);
    for (std::size_t i = 0; i < kRayPacket; ++i) backs += meetsBack(hits, i, occluders.others);
    const std::size_t sent = first + kRayPacket;
    if (8 * backs <= sent || 8 * backs >= 7 * sent) return 2 * backs > sent;
  }
  return 2 * backs > probes.size();
}

glm::vec3 unitOr(const glm::dvec3& v, const glm::vec3& fallback) {
  const double length = glm::length(v);
  return length > 0.0 ? glm::vec3(v / length) : fallback;
}

/// (1/pi) times the integral of V cos Y_i, from the means of V z, V z l and V z l l^T (VertexVisibility::transfer).
std::array<float, 9> transferOf(const Moments& mean, const std::array<glm::dvec3, 3>& frame) {
  const double local[3][3] = {
      {mean[kZXX], mean[kZXY], mean[kZXZ]}, {mean[kZXY], mean[kZYY], mean[kZYZ]}, {mean[kZXZ], mean[kZYZ], mean[kZZZ]}};
  double second[3][3] = {};
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) second[a][b] += frame[i][a] * local[i][j] * frame[j][b];
  const glm::dvec3 first = frame[0] * mean[kZX] + frame[1] * mean[kZY] + frame[2] * mean[kZZ];
  const double k0 = std::sqrt(1.0 / (4.0 * std::numbers::pi)), k1 = std::sqrt(3.0) * k0, k2 = std::sqrt(15.0) * k0;
  const double values[9] = {k0 * mean[kZ],
                            k1 * first.y,
                            k1 * first.z,
                            k1 * first.x,
                            k2 * second[0][1],
                            k2 * second[1][2],
                            0.5 * std::sqrt(5.0) * k0 * (3.0 * second[2][2] - mean[kZ]),
                            k2 * second[0][2],
                            0.5 * k2 * (second[0][0] - second[1][1])};
  std::array<float, 9> transfer;
  for (std::size_t i = 0; i < 9; ++i) transfer[i] = static_cast<float>(2.0 * values[i]);
  return transfer;
}

/// Means over the hemisphere from sums over hidden rays. What the ray set itself misses of each moment is taken off in proportion to what
/// is visible, so that an open point gets the closed form.
Moments meansOf(const Moments& hidden, const Table& table) {
  const auto rays = static_cast<double>(table.size());
  const double share = (rays - hidden[kOne]) / rays;
  Moments mean{};
  for (std::size_t m = 0; m < kMoments && share > 0.0; ++m) mean[m] = ((1.0 - share) * table.all[m] - hidden[m]) / rays + share * kWhole[m];
  return mean;
}

PointVisibility pointVisibility(const SurfacePoint& point, std::uint64_t index, const Moments& mean, bool transfer) {
  const std::array<glm::dvec3, 3> frame = frameOf(glm::dvec3(point.normal), azimuthOf(index));
  PointVisibility seen;
  seen.visible = static_cast<float>(mean[kOne]);
  seen.ambient = static_cast<float>(std::clamp(2.0 * mean[kZ], 0.0, 1.0));
  seen.direction = seen.bent = point.normal;
  if (mean[kOne] > 0.0 && mean[kOne] < 1.0) {
    seen.direction = unitOr(frame[0] * mean[kX] + frame[1] * mean[kY] + frame[2] * mean[kZ], point.normal);
    seen.bent = unitOr(frame[0] * mean[kZX] + frame[1] * mean[kZY] + frame[2] * mean[kZZ], point.normal);
  }
  if (transfer) seen.transfer = transferOf(mean, frame);
  return seen;
}

/// Spreads 21 bits so that two free ones follow each.
std::uint64_t spread(std::uint64_t v) {
  v = (v | v << 32) & 0x1f00000000ffff;
  v = (v | v << 16) & 0x1f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  return (v | v << 2) & 0x1249249249249249;
}

}  // namespace

std::vector<PointVisibility> traceVisibility(const Occluders& occluders, std::span<const SurfacePoint> points,
                                             const VisibilitySettings& settings, const Progress& progress) {
  const Table table = makeTable(settings.rays);
  const Table probes = makeTable(kProbes);
  const std::vector<std::uint32_t> order = mortonOrder(points);
  std::vector<PointVisibility> seen(points.size());
  tbb::enumerable_thread_specific<Batch> batches;
  std::atomic<std::size_t> done{0};
  std::atomic<bool> stopped{false};
  const std::size_t tiles = (order.size() + kTile - 1) / kTile;
  tbb::parallel_for(std::size_t{0}, tiles, [&](std::size_t tile) {
    if (stopped) return;
    const auto indices = std::span(order).subspan(tile * kTile).first(std::min(kTile, order.size() - tile * kTile));
    std::array<Eye, kTile> eyes;
    std::array<Moments, kTile> hidden{};
    for (std::size_t i = 0; i < indices.size(); ++i) eyes[i] = eyeOf(*occluders.self, points[indices[i]], indices[i]);
    traceHidden(occluders, std::span(eyes).first(indices.size()), table, batches.local(), hidden);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (seesFew(hidden[i], table)) hidden[i] = traceTwice(occluders, eyes[i], table, batches.local());
      PointVisibility& point = seen[indices[i]];
      point = pointVisibility(points[indices[i]], indices[i], meansOf(hidden[i], table), settings.transfer);
      point.interior = point.visible < 0.5f && isInterior(occluders, eyes[i], probes);
    }
    const std::size_t now = done += indices.size();
    if (progress && !progress(static_cast<double>(now) / static_cast<double>(order.size()))) stopped = true;
  });
  return seen;
}

std::vector<glm::dvec3> hemisphereDirections(int rays) {
  OVERCAST_REQUIRE(rays > 0 && rays <= kMostRays, "{} rays", rays);
  const std::size_t count = (static_cast<std::size_t>(rays) + kRayPacket - 1) / kRayPacket * kRayPacket;
  const double goldenAngle = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<glm::dvec3> directions;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 1.0 - (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    const double radius = std::sqrt(1.0 - z * z), angle = goldenAngle * static_cast<double>(i);
    directions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  sortIntoPackets(directions);
  return directions;
}

double azimuthOf(std::uint64_t index) {
  return 2.0 * std::numbers::pi * uniform(kSeed, index);
}

std::array<glm::dvec3, 3> frameOf(const glm::dvec3& normal, double azimuth) {
  const double sign = std::copysign(1.0, normal.z);
  const double a = -1.0 / (sign + normal.z), b = normal.x * normal.y * a;
  const glm::dvec3 x(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
  const glm::dvec3 y(b, sign + normal.y * normal.y * a, -normal.y);
  const double c = std::cos(azimuth), s = std::sin(azimuth);
  return {c * x + s * y, c * y - s * x, normal};
}

std::vector<std::uint32_t> mortonOrder(std::span<const SurfacePoint> points) {
  Box box;
  for (const SurfacePoint& point : points) include(box, point.position);
  const glm::dvec3 size = extent(box);
  const double longest = std::max({size.x, size.y, size.z});
  const double cells = longest > 0.0 ? 2097151.0 / longest : 0.0;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> codes(points.size());
  tbb::parallel_for(std::size_t{0}, codes.size(), [&](std::size_t i) {
    const glm::dvec3 cell = (points[i].position - box.min) * cells;
    const auto bits = [](double c) { return spread(static_cast<std::uint64_t>(c)); };
    codes[i] = {bits(cell.x) | bits(cell.y) << 1 | bits(cell.z) << 2, static_cast<std::uint32_t>(i)};
  });
  tbb::parallel_sort(codes.begin(), codes.end());
  std::vector<std::uint32_t> order(codes.size());
  std::transform(codes.begin(), codes.end(), order.begin(), [](const auto& code) { return code.second; });
  return order;
}

}  // namespace overcast
