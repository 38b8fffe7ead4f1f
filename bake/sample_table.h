// Sample tables: randomised low-discrepancy points that many surface points share. Private to bake.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace overcast {

/// A part of one randomised sequence, sorted so that neighbours in the table are neighbours on the hemisphere. Each entry holds a direction
/// of the hemisphere about z, distributed as the cosine to z, and two independent points of the unit square.
struct SampleTable {
  std::vector<float> x, y, z;
  std::vector<float> u, v;           ///< first point of the square
  std::vector<float> second, third;  ///< coordinates of the second
  std::size_t size() const { return x.size(); }
};

/// Points `first` .. `first + count` of `tables` sequences, each randomised by itself: the first two dimensions of Sobol's sequence under
/// Owen's nested scrambling (Owen 1995), further pairs of dimensions as the same in another random order (Burley 2020, "Practical
/// Hash-based Owen Scrambling", section 4). Any average over a table is an unbiased estimate; tables are independent of each other.
/// Prefixes of a power of two are stratified in every way that base 2 knows. The same for any number of threads.
std::vector<SampleTable> makeSampleTables(std::size_t tables, std::uint32_t first, std::uint32_t count, std::uint64_t seed);

}  // namespace overcast
