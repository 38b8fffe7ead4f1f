// Sky visibility of the estimators in double (DESIGN 5.4; Evans 2006, 9.6). Shares no code with the runtime.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "tests/reference/pyramid.h"

namespace overcast::reference {

/// C at `point` (voxels from the volume's corner) with unit `normal` and unit `up`, one tap for each level: exp(-k' sum f_i) divided by its
/// value over open ground facing the sky, with k' = k / sum d_i; at most 1, and eased into it: C^(E / (E + 1/16)), E = -ln C. Beyond half
/// a texel of a level inside the border that level is continued by the distance.
double publishedSky(const std::vector<Field>& levels, const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& up, double k,
                    double alpha);

struct Tap {
  double distance = 1.0;  ///< voxels
  double weight = 0.0;
  int level = 0;
};

struct Step {
  std::vector<double> weights;  ///< of the taps
  std::vector<double> gaps;     ///< between them
  double start = 0.0, slant = 0.0, height = 0.0;
};

/// Mean of exp(-max(e, 0)) over every `stride`th of 256 directions about `normal`, the first being stride / 2. Direction n is at radius
/// sqrt((91 n mod 256 + 1/2) / 256) and angle n / 256 of a turn of the disc below it, u is its cosine, and its taps lie in equal ratios
/// from first 2^(2.5 ((165 n mod 256 + 1/2) / 256 - 1/2)) to the border of the field, as runtime/passes/shade/shade.h has it. e is the sum
/// over steps of height (tanh z - tanh o), o = start + slant (1 - u), z = o + sum of weight g + sum of gap v.
double calibratedSky(const Field& field, const glm::dvec3& point, const glm::dvec3& normal, double first, const std::vector<Step>& steps,
                     int stride);

/// Mean over `axes` of the least clamp(phi / (d spread) + bias, 0, 1), to a power; `cone`: spread, bias, power.
double conesSky(const std::vector<Field>& levels, const glm::dvec3& point, const std::vector<glm::dvec3>& axes,
                const std::vector<Tap>& taps, const glm::dvec3& cone);

/// The field with that continuation: level `level` at a point in voxels of level 0.
double continuedField(const std::vector<Field>& levels, int level, const glm::dvec3& point);

}  // namespace overcast::reference
