#include "runtime/player/report.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "runtime/report/statistics.h"

namespace overcast {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kFewFrames = 4;

PassStatistics statisticsOf(std::string name, std::vector<double> times, std::size_t frames) {
  PassStatistics result{std::move(name), times.size(), frames - times.size(), 0.0, 0.0};
  if (times.empty()) return result;
  result.p95 = percentile(times, 0.95);
  result.median = median(std::move(times));
  return result;
}

Json jsonOf(const DeviceInfo& device) {
  return {{"index", device.index},   {"name", device.name},         {"kind", device.kind},
          {"driver", device.driver}, {"vulkan", device.apiVersion}, {"usable", device.usable}};
}

/// The middle one of the frames, so that it does not depend on how a camera starts or ends; 0 without frames.
std::uint64_t medianTriangles(std::vector<std::uint64_t> frames) {
  if (frames.empty()) return 0;
  const auto middle = frames.begin() + static_cast<std::ptrdiff_t>(frames.size() / 2);
  std::nth_element(frames.begin(), middle, frames.end());
  return *middle;
}

std::string text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::vector<PassStatistics> statistics(const std::vector<std::vector<PassTime>>& frames) {
  const std::size_t first = frames.size() > kFewFrames ? 1 : 0;
  const std::size_t measured = frames.size() - std::min(first, frames.size());
  if (measured == 0) return {};
  std::vector<PassStatistics> result;
  std::vector<double> totals(measured, 0.0);
  for (std::size_t pass = 0; pass < frames[0].size(); ++pass) {
    std::vector<double> times;
    for (std::size_t i = 0; i < measured; ++i) {
      const PassTime& time = frames[first + i][pass];
      if (time.skipped) continue;
      times.push_back(time.milliseconds);
      totals[i] += time.milliseconds;
    }
    result.push_back(statisticsOf(frames[0][pass].name, std::move(times), measured));
  }
  result.push_back(statisticsOf("frame", std::move(totals), measured));
  return result;
}

std::string table(const PlayResult& result) {
  std::string lines = fmt::format("device: {} ({}, {})\n", result.device.name, result.device.kind, result.device.driver);
  lines += fmt::format("{:<13} {:>12} {:>12} {:>8} {:>8}\n", "pass", "median ms", "p95 ms", "frames", "skipped");
  for (const PassStatistics& pass : statistics(result.frames)) {
    const std::string median = pass.frames > 0 ? fmt::format("{:.3f}", pass.median) : "-";
    const std::string p95 = pass.frames > 0 ? fmt::format("{:.3f}", pass.p95) : "-";
    lines += fmt::format("{:<13} {:>12} {:>12} {:>8} {:>8}\n", pass.name, median, p95, pass.frames, pass.skipped);
  }
  return lines + fmt::format("triangles drawn: {} (median)\n", medianTriangles(result.triangles));
}

std::string json(const PlayerOptions& options, const PlayResult& result) {
  Json passes = Json::array();
  for (const PassStatistics& pass : statistics(result.frames)) {
    Json entry{{"name", pass.name}, {"frames", pass.frames}, {"skipped", pass.skipped}};
    entry["median_ms"] = pass.frames > 0 ? Json(pass.median) : Json(nullptr);
    entry["p95_ms"] = pass.frames > 0 ? Json(pass.p95) : Json(nullptr);
    passes.push_back(entry);
  }
  return text({{"scene", options.scene.string()},
               {"device", jsonOf(result.device)},
               {"size", {options.width, options.height}},
               {"supersample", options.supersample},
               {"technique", nameOf(options.technique.technique)},
               {"frames", {options.firstFrame, options.lastFrame}},
               {"fps", options.framesPerSecond},
               {"triangles", medianTriangles(result.triangles)},
               {"passes", passes},
               {"pictures", result.pictures}});
}

std::string table(const std::vector<DeviceInfo>& devices) {
  std::string lines;
  for (const DeviceInfo& device : devices)
    lines += fmt::format("{}: {} ({}, {}, Vulkan {}){}\n", device.index, device.name, device.kind, device.driver, device.apiVersion,
                         device.usable ? "" : ", cannot be used: " + device.reason);
  return lines;
}

std::string json(const std::vector<DeviceInfo>& devices) {
  Json list = Json::array();
  for (const DeviceInfo& device : devices) {
    list.push_back(jsonOf(device));
    if (!device.usable) list.back()["reason"] = device.reason;
  }
  return text({{"devices", list}});
}

}  // namespace overcast
