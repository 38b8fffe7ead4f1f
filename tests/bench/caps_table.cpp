// Table of cap intersections: the error of every method beside its time, on the CPU and on a Vulkan device.
//   overcast-bench-caps [--pairs N] [--device NAME]
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "formats/console.h"
#include "runtime/vulkan/device.h"
#include "tests/bench/cap_pairs.h"
#include "tests/reference/caps.h"

namespace {

using namespace overcast;
using shared::CapPair;

constexpr int kRuns = 5;
constexpr int kRepeats = 256;  ///< of each pair on the device, so that reading it does not count

struct Method {
  const char* name;
  int number;
};
constexpr std::array kMethods{Method{"naive", shared::kMethodNaive}, Method{"clamped", shared::kMethodClamped},
                              Method{"stable", shared::kMethodStable}, Method{"smoothstep", shared::kMethodSmoothstep},
                              Method{"ours", shared::kMethodOurs}};

struct Kind {
  const char* name;
  PairKind kind;
};
constexpr std::array kKinds{Kind{"generic", PairKind::generic}, Kind{"down to 1e-4 rad", PairKind::small},
                            Kind{"sun-sized", PairKind::sun},   Kind{"tangent", PairKind::tangent},
                            Kind{"nested", PairKind::nested},   Kind{"hemispherical", PairKind::hemispherical}};

struct Errors {
  double largest = 0.0;
  double squares = 0.0;
  std::size_t counted = 0;
  std::size_t notNumbers = 0;
};

/// Of a method over pairs whose true areas are `truth`, relative to the smaller cap.
Errors errorsOf(int method, const std::vector<CapPair>& pairs, const std::vector<double>& truth) {
  Errors errors;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double whole = static_cast<double>(reference::capArea(std::min(pairs[i].first.w, pairs[i].second.w)));
    const double error = std::abs(static_cast<double>(shared::evaluatePair(method, pairs[i])) - truth[i]) / whole;
    if (std::isnan(error)) {
      ++errors.notNumbers;
      continue;
    }
    errors.largest = std::max(errors.largest, error);
    errors.squares += error * error;
    ++errors.counted;
  }
  return errors;
}

void printErrors(std::size_t count) {
  fmt::print("error in shares of the smaller cap, {} pairs each: largest, root of the mean square (and how many are not a number)\n",
             count);
  fmt::print("{:<17}", "caps");
  for (const Method& method : kMethods) fmt::print(" {:>22}", method.name);
  fmt::print("\n");
  for (const Kind& kind : kKinds) {
    const std::vector<CapPair> pairs = makePairs(kind.kind, count, 1);
    std::vector<double> truth;
    for (const CapPair& pair : pairs)
      truth.push_back(static_cast<double>(reference::capIntersection(pair.first.w, pair.second.w, pair.normal.w)));
    fmt::print("{:<17}", kind.name);
    for (const Method& method : kMethods) {
      const Errors errors = errorsOf(method.number, pairs, truth);
      const double mean = std::sqrt(errors.squares / static_cast<double>(std::max<std::size_t>(errors.counted, 1)));
      const std::string lost = errors.notNumbers > 0 ? fmt::format(" ({})", errors.notNumbers) : "";
      fmt::print(" {:>22}", fmt::format("{:.2g}, {:.2g}{}", errors.largest, mean, lost));
    }
    fmt::print("\n");
  }
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Nanoseconds per evaluation on one core.
double timeOnCpu(int method, const std::vector<CapPair>& pairs) {
  std::vector<double> times;
  float sum = 0.0f;
  for (int run = 0; run < kRuns; ++run) {
    const auto start = std::chrono::steady_clock::now();
    for (const CapPair& pair : pairs) sum += shared::evaluatePair(method, pair);
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - start;
    times.push_back(took.count() / static_cast<double>(pairs.size()));
  }
  volatile float sink = sum;
  static_cast<void>(sink);
  return median(times);
}

/// Nanoseconds per evaluation of the whole device.
Result<double> timeOnDevice(const Device& device, int method, const std::vector<CapPair>& pairs) {
  std::vector<double> times;
  for (int run = 0; run < kRuns; ++run) {
    const Result<DeviceRun> done = evaluateOnDevice(device, pairs, method, kRepeats);
    if (!done) return done.error();
    times.push_back(done.value().milliseconds * 1e6 / (static_cast<double>(pairs.size()) * kRepeats));
  }
  return median(times);
}

Result<Done> printTimes(const std::string& wanted) {
  Result<Device> device = openDevice({wanted, false, {}, false});
  if (!device) return device.error();
  fmt::print("time per evaluation (generic caps, medians of {}): one core; {}\n", kRuns, device.value().info.name);
  const std::vector<CapPair> onCpu = makePairs(PairKind::generic, 200'000, 2), onDevice = makePairs(PairKind::generic, 16'384, 2);
  Result<Done> result = Done{};
  for (const Method& method : kMethods) {
    const Result<double> time = timeOnDevice(device.value(), method.number, onDevice);
    if (time) {
      fmt::print("{:<17} {:>8.1f} ns {:>8.3f} ns\n", method.name, timeOnCpu(method.number, onCpu), time.value());
    } else {
      result = time.error();
    }
  }
  closeDevice(device.value());
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Error and time of the intersection of two spherical caps"};
  std::size_t pairs = 20'000;
  std::string device;
  app.add_option("--pairs", pairs, "pairs of each kind")->check(CLI::Range(1, 10'000'000))->capture_default_str();
  app.add_option("--device", device, "index or part of the name of the Vulkan device (default: the best GPU, else the CPU)");
  CLI11_PARSE(app, argc, argv);
  printErrors(pairs);
  const Result<Done> timed = printTimes(device);
  if (timed) return 0;
  printMessage(fmt::format("overcast-bench-caps: {}\n", message(timed.error())));
  return 1;
}
