// Random: numbers that depend on a seed and a place in the sequence alone, whichever thread asks.
#pragma once

#include <cstdint>

namespace overcast {

/// Number `counter` of the sequence `seed`, even in [0, 1): SplitMix64 (Steele, Lea, Flood 2014) of the counter.
inline double uniform(std::uint64_t seed, std::uint64_t counter) {
  std::uint64_t z = seed * 0xd1342543de82ef95u + (counter + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

}  // namespace overcast
