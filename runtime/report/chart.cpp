#include "runtime/report/chart.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/technique.h"

namespace overcast {
namespace {

constexpr double kWidth = 560.0, kHeight = 360.0;
constexpr double kLeft = 62.0, kRight = 14.0, kTop = 14.0, kBottom = 46.0;

/// A logarithmic axis with room at its ends; ticks at 1, 2 and 5 times powers of ten.
struct Axis {
  double low = 0.0;  ///< logarithms of 10
  double high = 1.0;
  double from = 0.0;  ///< pixels
  double to = 1.0;

  double at(double value) const { return from + (std::log10(value) - low) / (high - low) * (to - from); }
};

Axis axisOver(const std::vector<double>& values, double from, double to) {
  double least = 1e300, most = 0.0;
  for (const double value : values) {
    if (value <= 0.0) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  if (most <= 0.0) return {-1.0, 0.0, from, to};
  const double low = std::log10(least), high = std::log10(most);
  const double room = std::max(0.06 * (high - low), 0.08);
  return {low - room, high + room, from, to};
}

std::vector<double> ticksOf(const Axis& axis) {
  std::vector<double> ticks;
  const bool wide = axis.high - axis.low > 2.5;
  for (int power = static_cast<int>(std::floor(axis.low)); power <= static_cast<int>(std::ceil(axis.high)); ++power) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, power);
      if (wide && digit > 1.0) continue;
      if (std::log10(value) >= axis.low && std::log10(value) <= axis.high) ticks.push_back(value);
    }
  }
  return ticks;
}

std::string bytesText(double bytes) {
  if (bytes >= 1e6) return fmt::format("{:.4g} MB", bytes / 1e6);
  return bytes >= 1e3 ? fmt::format("{:.4g} kB", bytes / 1e3) : fmt::format("{:.4g} B", bytes);
}

std::string costText(Cost cost, double value) {
  return cost == Cost::bytes ? bytesText(value) : fmt::format("{:g}", value);
}

const char* costName(Cost cost) {
  switch (cost) {
    case Cost::frame:
      return "milliseconds of a frame, everything moves";
    case Cost::still:
      return "milliseconds of a frame, nothing moves";
    case Cost::bytes:
      break;
  }
  return "bytes on the device and of assets";
}

std::string grid(const Axis& across, const Axis& up, Cost cost) {
  std::string svg;
  for (const double tick : ticksOf(across))
    svg += fmt::format(
        "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/><text x=\"{0:.1f}\" y=\"{3:.1f}\" text-anchor=\"middle\">{4}</text>\n",
        across.at(tick), kTop, kHeight - kBottom, kHeight - kBottom + 16.0, costText(cost, tick));
  for (const double tick : ticksOf(up))
    svg += fmt::format(
        "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/><text x=\"{3:.1f}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n", kLeft,
        up.at(tick), kWidth - kRight, kLeft - 6.0, up.at(tick) + 4.0, tick);
  svg += fmt::format("<text class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", 0.5 * (kLeft + kWidth - kRight),
                     kHeight - 8.0, costName(cost));
  return svg +
         fmt::format(
             "<text class=\"axis\" transform=\"translate(14 {:.1f}) rotate(-90)\" text-anchor=\"middle\">RMSE of sky visibility</text>\n",
             0.5 * (kTop + kHeight - kBottom));
}

std::string titleOf(const ReportRow& row) {
  std::string text = fmt::format("{}\nRMSE {:.4f}, bias {:+.4f}, p99 {:.3f}, FLIP {:.3f}", row.setting, row.errors.rmse, row.errors.bias,
                                 row.errors.p99, row.errors.flip);
  if (row.errors.flicker >= 0.0) text += fmt::format(", flicker {:.4f}", row.errors.flicker);
  text += fmt::format("\nframe {:.3f} ms (p95 {:.3f}, noise {:.3f}), still {:.3f} ms\n{} on the device, {} of assets", row.frame.median,
                      row.frame.p95, row.frame.noise, row.still.median, bytesText(static_cast<double>(row.gpuBytes)),
                      bytesText(static_cast<double>(row.assetBytes)));
  if (!row.occluders.empty()) text += "\noccluders: " + row.occluders;
  return text;
}

std::string dot(const ReportRow& row, double x, double y) {
  const std::string colour = colourOf(familyOf(row));
  const bool ours = row.technique == nameOf(Technique::overcast);
  const std::string shape = ours ? fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5.5\"", x, y)
                                 : fmt::format("<path d=\"M{:.1f} {:.1f}l6 6l-6 6l-6 -6z\"", x, y - 6.0);
  return fmt::format("<g class=\"dot\">{} fill=\"{}\" stroke=\"{}\"/><title>{}</title></g>\n", shape, colour, colour,
                     escapedHtml(titleOf(row)));
}

}  // namespace

std::string escapedHtml(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string familyOf(const ReportRow& row) {
  if (row.technique != nameOf(Technique::overcast)) return row.technique;
  return row.apertureMode.empty() ? row.estimator : row.estimator + " with apertures";
}

std::string colourOf(const std::string& family) {
  constexpr std::array kColours{"#0b6e99", "#d1495b", "#2e8b57", "#8e5ea2", "#c77d0a", "#3d5a80", "#7a5c3e",
                                "#5f7f00", "#b5179e", "#00897b", "#546e7a", "#a03c00", "#4361ee", "#9a8c00"};
  std::uint32_t hash = 2166136261u;
  for (const char c : family) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return kColours[(hash >> 7) % kColours.size()];
}

std::string tradeoffChart(const ReportScene& scene, Cost cost) {
  const std::vector<Tradeoff> points = tradeoffs(scene, cost);
  std::vector<double> costs, errors;
  for (const Tradeoff& point : points) {
    costs.push_back(std::max(point.cost, cost == Cost::bytes ? 1e3 : 1e-3));
    errors.push_back(point.error);
  }
  const Axis across = axisOver(costs, kLeft, kWidth - kRight), up = axisOver(errors, kHeight - kBottom, kTop);
  const double floor = std::pow(10.0, up.low);
  const auto x = [&](const Tradeoff& point) { return across.at(costs[point.row]); };
  const auto y = [&](const Tradeoff& point) { return up.at(std::max(point.error, floor)); };
  std::string svg = fmt::format("<svg class=\"chart\" viewBox=\"0 0 {} {}\" role=\"img\">\n", kWidth, kHeight);
  svg += grid(across, up, cost);
  std::string line;
  for (const Tradeoff& point : paretoFront(points))
    line += line.empty() ? fmt::format("M{:.1f} {:.1f}", x(point), y(point)) : fmt::format("H{:.1f}V{:.1f}", x(point), y(point));
  if (!line.empty()) svg += fmt::format("<path class=\"front\" d=\"{}\"/>\n", line);
  for (const Tradeoff& point : points) svg += dot(scene.rows[point.row], x(point), y(point));
  return svg + "</svg>\n";
}

}  // namespace overcast
