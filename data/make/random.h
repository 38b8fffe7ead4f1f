// Random numbers that are the same on every machine: the distributions of the standard library are not.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include <glm/vec3.hpp>

namespace overcast {

struct Random {
  std::mt19937_64 engine;
};

/// In [low, high).
inline double uniform(Random& random, double low = 0.0, double high = 1.0) {
  return low + (high - low) * static_cast<double>(random.engine() >> 11) * 0x1p-53;
}

/// As often between 0.1 and 1 as between 1 and 10. `low` > 0.
inline double logUniform(Random& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}

/// From 0 to count - 1.
inline std::size_t index(Random& random, std::size_t count) {
  return static_cast<std::size_t>(uniform(random) * static_cast<double>(count));
}

/// Colours as they are picked for clay models: display-encoded, neither black nor glaring.
inline glm::dvec3 clayColour(Random& random) {
  constexpr std::array<glm::dvec3, 8> kColours = {{{0.78, 0.45, 0.32},
                                                   {0.58, 0.64, 0.48},
                                                   {0.86, 0.74, 0.52},
                                                   {0.46, 0.53, 0.60},
                                                   {0.90, 0.87, 0.80},
                                                   {0.62, 0.42, 0.44},
                                                   {0.40, 0.58, 0.58},
                                                   {0.80, 0.66, 0.60}}};
  return kColours[index(random, kColours.size())];
}

}  // namespace overcast
