#include "bake/sample_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <tbb/parallel_for.h>

#include "bake/random.h"

namespace overcast {
namespace {

constexpr std::uint64_t kTableSeed = 1995;

std::uint32_t reversed(std::uint32_t bits) {
  std::uint32_t result = 0;
  for (int i = 0; i < 32; ++i) result |= (bits >> i & 1u) << (31 - i);
  return result;
}

/// Second dimension of Sobol's sequence.
std::uint32_t sobol(std::uint32_t index) {
  std::uint32_t result = 0;
  for (std::uint32_t direction = 1u << 31; index != 0; index >>= 1, direction ^= direction >> 1)
    if (index & 1u) result ^= direction;
  return result;
}

/// Owen's scrambling; of an index it is another order in which aligned blocks stay together: every bit is turned by a coin of its own for
/// each value of the bits above it.
std::uint32_t scrambled(std::uint32_t bits, std::uint64_t seed) {
  std::uint32_t result = bits;
  for (int i = 31; i >= 0; --i) {
    // A one above the bits that lead tells prefixes of different lengths apart.
    const std::uint64_t prefix = (std::uint64_t{1} << 32 | bits) >> (i + 1);
    if (uniform(seed, prefix) < 0.5) result ^= 1u << i;
  }
  return result;
}

std::array<std::uint32_t, 2> pointOf(std::uint32_t index, std::uint64_t seed) {
  return {scrambled(reversed(index), seed), scrambled(sobol(index), seed + 1)};
}

std::uint64_t mortonCode(const std::array<std::uint32_t, 2>& point) {
  std::uint64_t code = 0;
  for (int i = 0; i < 16; ++i)
    for (std::size_t axis = 0; axis < 2; ++axis)
      code |= static_cast<std::uint64_t>(point[axis] >> (16 + i) & 1u) << (2 * static_cast<std::size_t>(i) + axis);
  return code;
}

double unit(std::uint32_t bits) {
  return (bits + 0.5) * 0x1p-32;
}

SampleTable makeTable(std::uint32_t first, std::uint32_t count, std::uint64_t seed) {
  struct Entry {
    std::uint64_t code;
    std::uint32_t index;
    std::array<std::uint32_t, 2> point;
  };
  std::vector<Entry> entries;
  for (std::uint32_t i = first; i < first + count; ++i) {
    const auto point = pointOf(i, seed);
    entries.push_back({mortonCode(point), i, point});
  }
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return std::pair(a.code, a.index) < std::pair(b.code, b.index); });
  SampleTable table;
  for (const Entry& entry : entries) {
    const double squared = unit(entry.point[0]), radius = std::sqrt(squared), angle = 2.0 * std::numbers::pi * unit(entry.point[1]);
    table.x.push_back(static_cast<float>(radius * std::cos(angle)));
    table.y.push_back(static_cast<float>(radius * std::sin(angle)));
    table.z.push_back(static_cast<float>(std::sqrt(1.0 - squared)));
    const auto light = pointOf(scrambled(entry.index, seed + 2), seed + 3), bounce = pointOf(scrambled(entry.index, seed + 5), seed + 6);
    table.u.push_back(static_cast<float>(unit(light[0])));
    table.v.push_back(static_cast<float>(unit(light[1])));
    table.second.push_back(static_cast<float>(unit(bounce[0])));
    table.third.push_back(static_cast<float>(unit(bounce[1])));
  }
  return table;
}

}  // namespace

std::vector<SampleTable> makeSampleTables(std::size_t tables, std::uint32_t first, std::uint32_t count, std::uint64_t seed) {
  std::vector<SampleTable> made(tables);
  tbb::parallel_for(std::size_t{0}, tables, [&](std::size_t i) {
    // Seeds that no two tables and dimensions share.
    const auto own = static_cast<std::uint64_t>(0x1p53 * uniform(seed ^ kTableSeed, i)) << 4;
    made[i] = makeTable(first, count, own);
  });
  return made;
}

}  // namespace overcast
