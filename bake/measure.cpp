#include "bake/measure.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/distance.h"
#include "bake/edges.h"
#include "bake/prepare.h"
#include "bake/random.h"
#include "bake/sign.h"
#include "formats/lighting.h"

namespace overcast {
namespace {

constexpr double kSigma = 0.02;  // all lengths here are shares of the diagonal
constexpr double kReach = 5.0 * kSigma;
constexpr double kClearlyOff = 0.01;
constexpr double kBehind = 0.02;  // winding number
constexpr double kFirstTap = 1.0 / 64.0;
constexpr double kReceiverSphere = 0.6;
constexpr double kGroundMargin = 0.5;
constexpr std::uint64_t kMostBatches = 16;
constexpr std::uint64_t kReceiverShare = 16;
constexpr std::size_t kPointTile = 256;

/// Sequences of random numbers that have nothing to do with each other.
enum class Sequence : std::uint64_t { influence, surface, ground, sphere };

double draw(const MeasureSettings& settings, Sequence sequence, std::uint64_t counter) {
  return uniform(settings.seed, counter + (static_cast<std::uint64_t>(sequence) << 56));
}

Box grown(const Box& box, double margin) {
  return {box.min - margin, box.max + margin};
}

glm::dvec3 pointOf(const Box& box, const MeasureSettings& settings, Sequence sequence, std::uint64_t index) {
  const glm::dvec3 share(draw(settings, sequence, 3 * index), draw(settings, sequence, 3 * index + 1),
                         draw(settings, sequence, 3 * index + 2));
  return box.min + share * extent(box);
}

double weightNear(double exact, double diagonal) {
  return std::exp(-std::abs(exact) / (kSigma * diagonal));
}

/// Points with their distances.
struct Measured {
  std::vector<glm::dvec3> points;
  std::vector<double> distance;
};

/// Points near the surface of a mesh about the origin. How many are drawn follows from the first batch: slender meshes fill less of their
/// box.
Measured drawNear(const Mesh& mesh, const Box& box, const MeasureSettings& settings) {
  const double reach = diagonal(box);
  const Box region = grown(box, kReach * reach);
  Measured kept;
  double sum = 0.0, squares = 0.0;
  const auto drawBatches = [&](std::uint64_t from, std::uint64_t to) {
    std::vector<glm::dvec3> points;
    for (std::uint64_t i = from * settings.samples; i < to * settings.samples; ++i)
      points.push_back(pointOf(region, settings, Sequence::surface, i));
    const std::vector<double> distance = distanceAt(mesh, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (distance[i] > kReach * reach) continue;
      kept.points.push_back(points[i]);
      kept.distance.push_back(distance[i]);
      const double weight = weightNear(distance[i], reach);
      sum += weight;
      squares += weight * weight;
    }
  };
  drawBatches(0, 1);
  const double effective = squares > 0.0 ? sum * sum / squares : 0.0;
  const double wanted = static_cast<double>(settings.samples) / 8.0;
  const double batches = effective > 0.0 ? std::ceil(wanted / effective) : static_cast<double>(kMostBatches);
  if (batches > 1.0) drawBatches(1, static_cast<std::uint64_t>(std::min(batches, static_cast<double>(kMostBatches))));
  return kept;
}

std::vector<Receiver> drawReceivers(const Box& box, const MeasureSettings& settings) {
  const double reach = diagonal(box);
  const Box region = grown(box, kGroundMargin * reach);
  std::vector<Receiver> receivers;
  for (std::uint64_t i = 0; i < std::max<std::uint64_t>(settings.samples / kReceiverShare, 1); ++i) {
    const double x = draw(settings, Sequence::ground, 2 * i), z = draw(settings, Sequence::ground, 2 * i + 1);
    const glm::dvec3 ground = region.min + glm::dvec3(x, 0.0, z) * extent(region);
    receivers.push_back({glm::dvec3(ground.x, box.min.y, ground.z), glm::dvec3(0.0, 1.0, 0.0)});
    const double height = 2.0 * draw(settings, Sequence::sphere, 2 * i) - 1.0;
    const double turn = 2.0 * std::numbers::pi * draw(settings, Sequence::sphere, 2 * i + 1);
    const double ring = std::sqrt(1.0 - height * height);
    const glm::dvec3 direction(ring * std::cos(turn), height, ring * std::sin(turn));
    receivers.push_back({centre(box) + kReceiverSphere * reach * direction, -direction});
  }
  return receivers;
}

/// Where the taps of a receiver lie, and the visibility that follows from the distances there. World up is local +y.
struct Sky {
  Estimator estimator;
  double first = 0.0;  ///< distance of the first tap

  double reachOf(int tap) const { return std::ldexp(first, tap); }

  glm::dvec3 tap(const Receiver& receiver, int index) const {
    return receiver.point + reachOf(index) * (receiver.normal + glm::dvec3(0.0, double{estimator.skyWeight}, 0.0));
  }

  double visibility(const Receiver& receiver, std::span<const double> object) const {
    double missing = 0.0, reach = 0.0;
    for (int i = 0; i < estimator.taps; ++i) {
      const double plane = glm::dot(tap(receiver, i) - receiver.point, receiver.normal);
      missing += reachOf(i) - std::min(object[static_cast<std::size_t>(i)], plane);
      reach += reachOf(i);
    }
    const double exponent = std::max(double{estimator.k} * (double{estimator.skyWeight} + missing / reach), 0.0);
    return std::exp(-exponent * exponent / (exponent + 1.0 / 16.0));
  }
};

Sky skyAround(double reach) {
  return {Estimator{}, kFirstTap * reach};
}

/// The part of the probes that a share of them takes.
struct Selection {
  std::size_t influence = 0;  ///< points [0, influence)
  std::size_t nearBegin = 0;  ///< points [nearBegin, nearEnd)
  std::size_t nearEnd = 0;
  std::size_t receivers = 0;
};

Selection select(const Probes& probes, double share) {
  const auto part = [&](std::size_t count) {
    return count == 0 ? 0 : std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil(share * static_cast<double>(count))), 1, count);
  };
  const auto samples = static_cast<std::size_t>(probes.settings.samples);
  return {part(samples), samples, samples + part(probes.nearEnd - samples), part(probes.receivers.size())};
}

bool isAmbiguous(double winding) {
  return std::abs(winding) > 0.2 && std::abs(winding) < 0.8;
}

bool isKnown(const Probes& probes, double winding) {
  return std::abs(winding) <= 0.2 || (std::abs(winding) >= 0.8 && probes.ambiguousSign <= kSheet);
}

/// What phi should have been at a point, given what it is.
struct Truth {
  double distance = 0.0;
  bool free = false;   ///< any smaller |phi| would have done
  bool known = false;  ///< the sign is
};

/// Which side of an open mesh `sampled` takes for solid: that of positive (1) or of negative (-1) winding numbers.
double solidSide(const Probes& probes, std::span<const double> sampled) {
  double sum = 0.0;
  for (std::size_t i = static_cast<std::size_t>(probes.settings.samples); i < probes.nearEnd; ++i)
    if (sampled[i] < 0.0) sum += probes.winding[i];
  return sum < 0.0 ? -1.0 : 1.0;
}

Truth truthAt(const Probes& probes, std::size_t i, double sampled, double side) {
  const double w = probes.winding[i], exact = probes.exact[i];
  const bool known = isKnown(probes, w);
  const bool inside = known ? std::abs(w) > 0.5 : sampled < 0.0;
  const bool free = !probes.found.closed && (probes.atRim[i] || side * w > kBehind) && !(known && inside && sampled >= 0.0);
  return {free ? std::clamp(sampled, -exact, exact) : inside ? -exact : exact, free, known && !free};
}

std::vector<Truth> truthFor(const Probes& probes, std::span<const double> sampled) {
  const double side = solidSide(probes, sampled);
  std::vector<Truth> truth;
  truth.reserve(sampled.size());
  for (std::size_t i = 0; i < sampled.size(); ++i) truth.push_back(truthAt(probes, i, sampled[i], side));
  return truth;
}

double skyError(const Probes& probes, std::size_t receivers, std::span<const double> sampled, std::span<const Truth> truth) {
  const Sky sky = skyAround(probes.diagonal);
  const auto taps = static_cast<std::size_t>(sky.estimator.taps);
  std::vector<double> exact(taps);
  double squares = 0.0;
  for (std::size_t r = 0; r < receivers; ++r) {
    const std::size_t first = probes.nearEnd + r * taps;
    for (std::size_t i = 0; i < taps; ++i) exact[i] = truth[first + i].distance;
    const double difference =
        sky.visibility(probes.receivers[r], sampled.subspan(first, taps)) - sky.visibility(probes.receivers[r], exact);
    squares += difference * difference;
  }
  return receivers == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(receivers));
}

/// Values of `distance` at the selected points; the rest stays zero.
std::vector<double> sampleAt(const DistanceFunction& distance, const Probes& probes, const Selection& selection) {
  std::vector<double> sampled(probes.points.size(), 0.0);
  const auto fill = [&](std::size_t from, std::size_t to) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(from, to, kPointTile), [&](const tbb::blocked_range<std::size_t>& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) sampled[i] = distance(probes.points[i]);
    });
  };
  const auto taps = static_cast<std::size_t>(skyAround(probes.diagonal).estimator.taps);
  fill(0, selection.influence);
  fill(selection.nearBegin, selection.nearEnd);
  fill(probes.nearEnd, probes.nearEnd + selection.receivers * taps);
  return sampled;
}

/// Where no place of the mesh is nearer than its boundary edges.
std::vector<std::uint8_t> nearestAtRim(const Mesh& mesh, const Probes& probes) {
  constexpr double kSame = 1e-9;
  Mesh rim;
  rim.positions = mesh.positions;
  for (const DirectedEdge& edge : netBoundary(mesh.triangles)) rim.triangles.emplace_back(edge.from, edge.to, edge.to);
  const std::vector<double> distance = distanceAt(rim, probes.points);
  std::vector<std::uint8_t> atRim;
  for (std::size_t i = 0; i < distance.size(); ++i) atRim.push_back(distance[i] <= probes.exact[i] + kSame * probes.diagonal);
  return atRim;
}

MeasuredError errorOf(const Probes& probes, const Selection& selection, std::span<const double> sampled, std::span<const Truth> truth) {
  MeasuredError error;
  error.samples = selection.influence;
  error.seed = probes.settings.seed;
  error.method = kMeasureMethod;
  const auto look = [&](std::size_t i) {
    const double difference = std::abs(sampled[i] - truth[i].distance);
    error.max = std::max(error.max, difference);
    error.signErrors +=
        truth[i].known && std::abs(truth[i].distance) > kClearlyOff * probes.diagonal && (sampled[i] < 0.0) != (truth[i].distance < 0.0);
    return difference;
  };
  std::vector<double> differences;
  double squares = 0.0;
  for (std::size_t i = 0; i < selection.influence; ++i) {
    differences.push_back(look(i));
    squares += differences.back() * differences.back();
  }
  error.rms = std::sqrt(squares / static_cast<double>(selection.influence));
  const std::size_t within = (differences.size() * 99 + 99) / 100 - 1;
  std::nth_element(differences.begin(), differences.begin() + static_cast<std::ptrdiff_t>(within), differences.end());
  error.p99 = differences[within];

  double weighted = 0.0, weights = 0.0;
  for (std::size_t i = selection.nearBegin; i < selection.nearEnd; ++i) {
    const double difference = look(i), weight = weightNear(probes.exact[i], probes.diagonal);
    weighted += weight * difference * difference;
    if (!truth[i].free || difference > 0.0) weights += weight;
  }
  error.surfaceRms = weights > 0.0 ? std::sqrt(weighted / weights) : error.rms;
  error.skyRmse = skyError(probes, selection.receivers, sampled, truth);
  return error;
}

/// A grid over a box about the origin, for the lattice of the winding number.
Grid gridOver(const Box& box) {
  constexpr int kCells = 64;
  const glm::dvec3 size = extent(box);
  Grid grid;
  grid.size = glm::ivec3(kCells + 1);
  grid.voxelSize = std::max({size.x, size.y, size.z}) / kCells;
  grid.origin = glm::dvec3(-0.5 * kCells * grid.voxelSize);
  return grid;
}

/// The field of `volume`'s sheets at every point of the probes, known throughout.
std::vector<Truth> sheetTruth(const Volume& volume, const Probes& probes) {
  std::vector<glm::dvec3> points = probes.points;
  for (glm::dvec3& point : points) point -= probes.prepared->middle;
  const Box box = bounds(probes.prepared->repaired.mesh);
  std::vector<Truth> truth;
  for (const double phi : fieldAt(sheetParts(volume, probes), volume.sheetThickness, gridOver(grown(box, probes.diagonal)), points))
    truth.push_back({phi, false, true});
  return truth;
}

}  // namespace

Probes drawProbes(const Mesh& mesh, const MeasureSettings& settings) {
  OVERCAST_REQUIRE(settings.samples > 0, "measuring at {} points", settings.samples);
  auto preparedMesh = std::make_shared<const PreparedMesh>(prepare(mesh));
  const PreparedMesh& prepared = *preparedMesh;
  const Mesh& centred = prepared.repaired.mesh;
  const Box box = bounds(centred);
  Probes probes;
  probes.settings = settings;
  probes.found = prepared.repaired.found;
  probes.diagonal = diagonal(box);
  const Box influence = grown(box, probes.diagonal);
  for (std::uint64_t i = 0; i < settings.samples; ++i) probes.points.push_back(pointOf(influence, settings, Sequence::influence, i));
  probes.receivers = drawReceivers(box, settings);
  const Sky sky = skyAround(probes.diagonal);
  for (const Receiver& receiver : probes.receivers)
    for (int i = 0; i < sky.estimator.taps; ++i) probes.points.push_back(sky.tap(receiver, i));
  probes.exact = distanceAt(centred, probes.points);
  const Measured near = drawNear(centred, box, settings);
  const auto behindFirst = static_cast<std::ptrdiff_t>(settings.samples);
  probes.points.insert(probes.points.begin() + behindFirst, near.points.begin(), near.points.end());
  probes.exact.insert(probes.exact.begin() + behindFirst, near.distance.begin(), near.distance.end());
  probes.nearEnd = settings.samples + near.points.size();

  probes.winding = windingAt(centred, gridOver(influence), probes.points);
  if (!probes.found.closed) probes.atRim = nearestAtRim(centred, probes);
  const auto nearPoints = std::span(probes.winding).subspan(settings.samples, near.points.size());
  const auto ambiguous = std::count_if(nearPoints.begin(), nearPoints.end(), isAmbiguous);
  if (!near.points.empty()) probes.ambiguousSign = static_cast<double>(ambiguous) / static_cast<double>(near.points.size());
  for (glm::dvec3& point : probes.points) point += prepared.middle;
  for (Receiver& receiver : probes.receivers) receiver.point += prepared.middle;
  probes.table = std::make_shared<const SheetTable>(sheetTable(centred));
  probes.prepared = std::move(preparedMesh);
  return probes;
}

SheetParts sheetParts(const Volume& volume, const Probes& probes) {
  const bool stated = volume.sheetThickness > 0.0;
  const SheetMode mode = !stated ? SheetMode::none : volume.inside == Inside::none ? SheetMode::all : SheetMode::automatic;
  return takeApart(probes.prepared->repaired.mesh, findSheets(*probes.table, mode, volume.sheetThickness));
}

MeasuredError measure(const DistanceFunction& distance, const Probes& probes, double share) {
  const Selection selection = select(probes, share);
  const std::vector<double> sampled = sampleAt(distance, probes, selection);
  return errorOf(probes, selection, sampled, truthFor(probes, sampled));
}

MeasuredError measure(const Asset& asset, const Probes& probes, double share) {
  const auto distance = [&](const glm::dvec3& point) { return sampleAsset(asset, point); };
  const auto* volume = std::get_if<Volume>(&asset);
  if (!volume || !(volume->sheetThickness > 0.0)) return measure(distance, probes, share);
  const Selection selection = select(probes, share);
  return errorOf(probes, selection, sampleAt(distance, probes, selection), sheetTruth(*volume, probes));
}

}  // namespace overcast
