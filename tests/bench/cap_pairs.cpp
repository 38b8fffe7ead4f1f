#include "tests/bench/cap_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>
#include <random>
#include <span>

#include <glm/geometric.hpp>

#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"
#include "runtime/vulkan/timer.h"

namespace overcast {
namespace {

using shared::CapPair;

static_assert(sizeof(CapPair) == 48 && offsetof(CapPair, second) == 32);

constexpr double kSmallest = 1e-4;
constexpr double kWidest = 1.5707962;  ///< the single float below pi/2

struct Random {
  std::mt19937 engine;
  double uniform(double low, double high) { return low + (high - low) * (static_cast<double>(engine()) / 4294967296.0); }
  double logarithmic(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  glm::dvec3 direction() {
    const double z = uniform(-1.0, 1.0), angle = uniform(0.0, 2.0 * std::numbers::pi), s = std::sqrt(1.0 - z * z);
    return {s * std::cos(angle), s * std::sin(angle), z};
  }
};

struct Radii {
  float first;
  float second;
};

Radii radiiOf(PairKind kind, Random& random) {
  const auto drawn = [&](double low) { return static_cast<float>(random.logarithmic(low, kWidest)); };
  switch (kind) {
    case PairKind::sun:
      return {drawn(0.1), 0.00465f};
    case PairKind::generic:
      return {static_cast<float>(random.uniform(0.1, kWidest)), static_cast<float>(random.uniform(0.1, kWidest))};
    case PairKind::hemispherical:
      return {static_cast<float>(kWidest), random.engine() % 2 ? drawn(kSmallest) : static_cast<float>(random.uniform(1.5, kWidest))};
    default:
      return {drawn(kSmallest), drawn(kSmallest)};
  }
}

/// How far apart, as 1 (the smaller cap just within) to 0 (just apart); beyond both ends too.
double placeOf(PairKind kind, Random& random) {
  if (kind == PairKind::nested) return 1.0 + (random.engine() % 2 ? random.logarithmic(1e-7, 1.0) : random.uniform(0.0, 5.0));
  if (kind == PairKind::apart) return random.engine() % 2 ? -random.logarithmic(1e-7, 1.0) : -random.uniform(0.0, 5.0);
  if (kind != PairKind::tangent) return random.uniform(0.0, 1.0);
  const double off = random.logarithmic(1e-6, 1e-2);
  return random.engine() % 2 ? off : 1.0 - off;
}

}  // namespace

std::vector<CapPair> makePairs(PairKind kind, std::size_t count, std::uint32_t seed) {
  Random random{std::mt19937(seed)};
  std::vector<CapPair> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    Radii radii = radiiOf(kind, random);
    if (random.engine() % 2) std::swap(radii.first, radii.second);
    const double small = std::min(radii.first, radii.second), wide = std::max(radii.first, radii.second);
    const double apart = std::clamp(wide + small - 2.0 * small * placeOf(kind, random), 0.0, std::numbers::pi);
    const glm::dvec3 axis = random.direction();
    const glm::dvec3 side = glm::normalize(glm::cross(axis, random.direction()));
    const glm::dvec3 other = std::cos(apart) * axis + std::sin(apart) * side;
    pairs.push_back({glm::vec4(random.direction(), apart), glm::vec4(axis, radii.first), glm::vec4(other, radii.second)});
  }
  return pairs;
}

Result<DeviceRun> evaluateOnDevice(const Device& device, const std::vector<CapPair>& pairs, int method, int repeats) {
  const Shader shader{"tests/bench/cap_methods.comp.glsl",
                      {{"OVERCAST_METHOD", std::to_string(method)}, {"OVERCAST_REPEATS", std::to_string(repeats)}}};
  const std::vector<Binding> bindings{{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}, {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
  Result<Pipeline> pipeline = makeComputePipeline(device, {shader, bindings, 0});
  if (!pipeline) return pipeline.error();
  DescriptorSet set = makeDescriptorSet(device, pipeline.value()).value();
  GpuBuffer in = makeBufferWith(device, std::as_bytes(std::span(pairs)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT).value();
  GpuBuffer out = makeBuffer(device, pairs.size() * sizeof(float), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::readback).value();
  PassTimer timer = makePassTimer(device, {"caps"}).value();
  writeBuffer(device, set, 0, in);
  writeBuffer(device, set, 1, out);
  const Result<Done> done = runCommands(device, [&](VkCommandBuffer commands) {
    beginTimedFrame(commands, timer, 0);
    beginPass(commands, timer, 0, 0);
    bind(commands, pipeline.value(), set);
    vkCmdDispatch(commands, groups(static_cast<std::uint32_t>(pairs.size()), 64), 1, 1);
    endPass(commands, timer, 0, 0);
    barrier(commands, kComputeWrite, kHostRead);
  });
  DeviceRun run;
  run.results.resize(pairs.size());
  std::memcpy(run.results.data(), out.mapped, pairs.size() * sizeof(float));
  if (done) run.milliseconds = passTimes(device, timer, 0).value()[0].milliseconds;
  destroyPassTimer(device, timer);
  destroyBuffer(device, out);
  destroyBuffer(device, in);
  destroyDescriptorSet(device, set);
  destroyPipeline(device, pipeline.value());
  if (!done) return done.error();
  return run;
}

}  // namespace overcast
