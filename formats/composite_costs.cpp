#include "formats/composite_costs.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "formats/composite_costs_default.h"
#include "formats/files.h"
#include "formats/json_fields.h"

namespace overcast {
namespace {

constexpr const char* kFormat = "overcast-composite-costs";
constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 24;

/// What tells the entries of one representation apart.
struct Key {
  Representation representation = Representation::volume;
  std::string variant;
  int bits = 0;
  int size = 0;
};

// One function per kind.
Key keyOf(const Volume& volume, VolumeBits bits) {
  const int count = bitCount(chooseBits(volume, bits));
  return {Representation::volume, "", std::min(count, 16), std::max({volume.size.x, volume.size.y, volume.size.z})};
}
Key keyOf(const Primitive& primitive, VolumeBits) {
  return {Representation::primitive, name(primitive.shape), 0, 0};
}
Key keyOf(const RadiusField& field, VolumeBits) {
  return {Representation::radius, "", 0, field.levels.front().side};
}
Key keyOf(const HeightField& field, VolumeBits) {
  return {Representation::heightfield, field.back.empty() ? "single" : "pair", 0, std::max(field.size.x, field.size.y)};
}

/// The entries for the key, by rising size; those of other variants and bits where it has none of its own.
std::vector<CompositeCost> entriesFor(const CompositeCosts& costs, const Key& key) {
  std::vector<CompositeCost> alike, same;
  for (const CompositeCost& cost : costs.costs) {
    if (cost.representation != key.representation) continue;
    alike.push_back(cost);
    if (cost.variant == key.variant && cost.bits == key.bits) same.push_back(cost);
  }
  std::vector<CompositeCost>& entries = same.empty() ? alike : same;
  std::stable_sort(entries.begin(), entries.end(), [](const CompositeCost& a, const CompositeCost& b) { return a.size < b.size; });
  return entries;
}

void readCost(Fields fields, CompositeCost& cost) {
  std::string text;
  fields.text("representation", text, false);
  const auto representation = representationNamed(text);
  if (!representation) fields.fail("representation", fmt::format("'{}' is not known", text));
  cost.representation = representation.value_or(cost.representation);
  if (fields.has("variant")) fields.text("variant", cost.variant, false);
  if (fields.has("size")) fields.integer("size", cost.size, 1, kMaxVolumeSide);
  if (fields.has("bits")) fields.integer("bits", cost.bits, 1, 32);
  fields.number("median", cost.median, kSmallestNumber, 1e12);
  fields.number("least", cost.least, kSmallestNumber, 1e12);
  fields.number("most", cost.most, kSmallestNumber, 1e12);
}

void readCosts(Fields& fields, CompositeCosts& costs) {
  std::string format;
  fields.text("format", format, false);
  if (format != kFormat) fields.fail("format", fmt::format("is '{}', not '{}'", format, kFormat));
  fields.version(kCompositeCostsVersion);
  fields.text("device", costs.device, false);
  fields.text("kind", costs.kind, true);
  fields.text("driver", costs.driver, true);
  fields.integer("objects", costs.objects, 1, 1 << 20);
  fields.integer("voxels", costs.voxels, 1, 1 << 12);
  fields.integer("runs", costs.runs, 1, 1 << 20);
  const std::size_t count = fields.arraySize("costs");
  for (std::size_t i = 0; i < count; ++i) readCost(fields.element("costs", i), costs.costs.emplace_back());
  for (const Representation needed :
       {Representation::volume, Representation::primitive, Representation::radius, Representation::heightfield})
    if (std::none_of(costs.costs.begin(), costs.costs.end(), [&](const CompositeCost& cost) { return cost.representation == needed; }))
      fields.fail("costs", fmt::format("have no entry of a {}", name(needed)));
}

}  // namespace

const CompositeCosts& defaultCompositeCosts() {
  static const CompositeCosts costs = [] {
    auto parsed = parseCompositeCosts(kDefaultCompositeCosts, "the built-in composite costs");
    OVERCAST_REQUIRE(parsed.ok(), "{}", message(parsed.error()));
    return std::move(parsed).value();
  }();
  return costs;
}

double compositeCost(const CompositeCosts& costs, const Asset& asset, VolumeBits volumeBits) {
  const Key key = std::visit([&](const auto& kind) { return keyOf(kind, volumeBits); }, asset);
  const std::vector<CompositeCost> entries = entriesFor(costs, key);
  OVERCAST_REQUIRE(!entries.empty(), "no composite cost of a {} among {}", name(key.representation), costs.costs.size());
  const auto above = std::find_if(entries.begin(), entries.end(), [&](const CompositeCost& cost) { return cost.size >= key.size; });
  if (above == entries.end()) return entries.back().median;
  if (above == entries.begin() || above->size == key.size) return above->median;
  const CompositeCost& below = *(above - 1);
  const double share = std::log2(double{1} * key.size / below.size) / std::log2(double{1} * above->size / below.size);
  return below.median + share * (above->median - below.median);
}

std::string compositeCostsJson(const CompositeCosts& costs) {
  Json json = {{"format", kFormat},      {"version", kCompositeCostsVersion}, {"device", costs.device}, {"kind", costs.kind},
               {"driver", costs.driver}, {"objects", costs.objects},          {"voxels", costs.voxels}, {"runs", costs.runs},
               {"costs", Json::array()}};
  for (const CompositeCost& cost : costs.costs) {
    Json entry = {{"representation", name(cost.representation)}};
    if (!cost.variant.empty()) entry["variant"] = cost.variant;
    if (cost.size > 0) entry["size"] = cost.size;
    if (cost.bits > 0) entry["bits"] = cost.bits;
    for (const auto& [key, value] : {std::pair{"median", cost.median}, std::pair{"least", cost.least}, std::pair{"most", cost.most}})
      entry[key] = value;
    json["costs"].push_back(std::move(entry));
  }
  return dumpJson(json, 2) + "\n";
}

Result<CompositeCosts> parseCompositeCosts(std::string_view json, const std::string& place) {
  return parseObject<CompositeCosts>(json, place, readCosts);
}

Result<CompositeCosts> readCompositeCosts(const std::filesystem::path& path) {
  const auto bytes = readFile(path, kLargestFile);
  if (!bytes) return bytes.error();
  const auto text = std::string_view(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size());
  auto costs = parseCompositeCosts(text, "");
  if (!costs) return Error{path.string(), costs.error().place, costs.error().reason};
  return costs;
}

}  // namespace overcast
