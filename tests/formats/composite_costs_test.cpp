#include "formats/composite_costs.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/formats/json_schema.h"
#include "tests/formats/radius_fields.h"
#include "tests/formats/support.h"

namespace overcast {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;

CompositeCost cost(Representation representation, const std::string& variant, int size, int bits, double median) {
  return {representation, variant, size, bits, median, 0.5 * median, 2.0 * median};
}

CompositeCosts smallCosts() {
  CompositeCosts costs{"A device", "CPU", "driver 1", 16, 64, 9, {}};
  costs.costs = {cost(Representation::primitive, "cuboid", 0, 0, 1.0),  cost(Representation::primitive, "ellipsoid", 0, 0, 3.0),
                 cost(Representation::radius, "", 8, 0, 4.0),           cost(Representation::heightfield, "single", 8, 0, 5.0),
                 cost(Representation::heightfield, "pair", 8, 0, 10.0), cost(Representation::volume, "", 8, 8, 2.0),
                 cost(Representation::volume, "", 32, 8, 6.0),          cost(Representation::volume, "", 8, 16, 20.0)};
  return costs;
}

Volume volumeOf(const glm::ivec3& size) {
  Volume volume;
  volume.size = size;
  volume.voxelSize = 1.0;
  volume.distance.assign(static_cast<std::size_t>(size.x * size.y * size.z), 1.0f);
  return volume;
}

std::string errorOf(const Json& json) {
  const auto parsed = parseCompositeCosts(json.dump(), "x");
  return parsed ? "" : message(parsed.error());
}

TEST(CompositeCosts, AreReadBackAsTheyWere) {
  const TemporaryFolder folder;
  const CompositeCosts costs = smallCosts();
  std::ofstream(folder / "costs.json") << compositeCostsJson(costs);
  const auto read = readCompositeCosts(folder / "costs.json");
  ASSERT_TRUE(read.ok()) << message(read.error());
  EXPECT_EQ(compositeCostsJson(read.value()), compositeCostsJson(costs));
  ASSERT_EQ(read.value().costs.size(), costs.costs.size());
  EXPECT_EQ(read.value().costs[7].bits, 16);
  EXPECT_EQ(read.value().costs[7].median, 20.0);
  EXPECT_EQ(read.value().driver, "driver 1");
}

TEST(CompositeCosts, KeepToTheirSchema) {
  const Json schema = test::schema("composite_costs");
  EXPECT_EQ(test::violation(schema, Json::parse(compositeCostsJson(smallCosts())), schema), "");
  EXPECT_EQ(test::violation(schema, Json::parse(compositeCostsJson(defaultCompositeCosts())), schema), "");
}

TEST(CompositeCosts, AreLookedUpByWhatAnAssetIs) {
  const CompositeCosts costs = smallCosts();
  const auto eight = [&](const glm::ivec3& size) { return compositeCost(costs, volumeOf(size), VolumeBits::snorm8); };
  EXPECT_DOUBLE_EQ(eight({8, 4, 4}), 2.0);
  EXPECT_DOUBLE_EQ(eight({2, 16, 3}), 4.0) << "half way from 8 to 32 in the logarithm";
  EXPECT_DOUBLE_EQ(eight({32, 32, 32}), 6.0);
  EXPECT_DOUBLE_EQ(eight({2, 2, 100}), 6.0) << "beyond all sizes";
  EXPECT_DOUBLE_EQ(eight({2, 2, 2}), 2.0);
  EXPECT_DOUBLE_EQ(compositeCost(costs, volumeOf({8, 8, 8})), 20.0) << "half floats unless they do not fit";
  EXPECT_DOUBLE_EQ(compositeCost(costs, volumeOf({8, 8, 8}), VolumeBits::single), 20.0) << "devices hold half floats";
  EXPECT_DOUBLE_EQ(compositeCost(costs, asStored(volumeOf({8, 8, 8}), VolumeBits::snorm8)), 2.0);
  EXPECT_DOUBLE_EQ(compositeCost(costs, Primitive{PrimitiveShape::ellipsoid, {}, {1, 0, 0, 0}, {1, 1, 1}}), 3.0);
  EXPECT_DOUBLE_EQ(compositeCost(costs, test::fieldOf(reference::bumpyRadius(), 16)), 4.0);
  HeightField field;
  field.size = {16, 8};
  EXPECT_DOUBLE_EQ(compositeCost(costs, field), 5.0);
  field.back.resize(1);
  EXPECT_DOUBLE_EQ(compositeCost(costs, field), 10.0);
}

TEST(CompositeCosts, KindsThatWereNotMeasuredTakeTheirRepresentations) {
  CompositeCosts costs = smallCosts();
  std::erase_if(costs.costs, [](const CompositeCost& entry) { return entry.variant == "pair" || entry.bits == 8; });
  HeightField field;
  field.size = {8, 8};
  field.back.resize(1);
  EXPECT_DOUBLE_EQ(compositeCost(costs, field), 5.0);
  EXPECT_DOUBLE_EQ(compositeCost(costs, volumeOf({8, 8, 8}), VolumeBits::snorm8), 20.0);
}

TEST(CompositeCosts, WhatIsWrongIsNamed) {
  const Json good = Json::parse(compositeCostsJson(smallCosts()));
  EXPECT_EQ(errorOf(good), "");
  const auto with = [&](const std::string& pointer, const Json& value) {
    Json changed = good;
    changed[Json::json_pointer(pointer)] = value;
    return errorOf(changed);
  };
  EXPECT_THAT(with("/format", "other"), HasSubstr("other"));
  EXPECT_THAT(with("/version", 2), HasSubstr("newer"));
  EXPECT_THAT(with("/costs/3/median", -1.0), HasSubstr("costs/3/median"));
  EXPECT_THAT(with("/costs/3/representation", "cloud"), HasSubstr("cloud"));
  EXPECT_THAT(with("/costs", Json::array()), HasSubstr("no entry of a volume"));
  EXPECT_THAT(errorOf(Json::array()), HasSubstr("not an object"));
  const auto missing = readCompositeCosts("/nowhere/costs.json");
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(message(missing.error()), HasSubstr("costs.json"));
}

}  // namespace
}  // namespace overcast
