#include "tests/reference/primitive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "tests/reference/distance.h"
#include "tests/reference/shapes.h"

namespace overcast::reference {
namespace {

struct Angles {
  double theta = 0.0, phi = 0.0, distance = 0.0;
};

Angles at(const glm::dvec3& point, const glm::dmat4& worldFromBall, double theta, double phi) {
  const glm::dvec4 onBall(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta), 1.0);
  return {theta, phi, glm::distance(point, glm::dvec3(worldFromBall * onBall))};
}

}  // namespace

double cuboidDistance(const glm::dvec3& point, const glm::dmat4& worldFromCube) {
  Mesh mesh = boxMesh(glm::dvec3(1.0));
  for (glm::dvec3& p : mesh.positions) p = glm::dvec3(worldFromCube * glm::dvec4(p, 1.0));
  const glm::dvec3 own = glm::abs(glm::dvec3(glm::inverse(worldFromCube) * glm::dvec4(point, 1.0)));
  const double nearest = distance(mesh, std::span(&point, 1)).front();
  return std::max({own.x, own.y, own.z}) < 1.0 ? -nearest : nearest;
}

double ellipsoidDistance(const glm::dvec3& point, const glm::dmat4& worldFromBall) {
  constexpr int kTheta = 64, kPhi = 128, kNearest = 8;
  constexpr double kCell = std::numbers::pi / kTheta;
  std::vector<Angles> all;
  for (int i = 0; i <= kTheta; ++i)
    for (int j = 0; j < kPhi; ++j) all.push_back(at(point, worldFromBall, i * kCell, j * kCell));
  const auto nearer = [](const Angles& a, const Angles& b) { return a.distance < b.distance; };
  std::partial_sort(all.begin(), all.begin() + kNearest, all.end(), nearer);
  all.resize(kNearest);
  for (Angles& best : all)
    for (double cell = kCell; cell > 1e-9; cell *= 0.5)
      for (bool better = true; better;) {
        const Angles about = best;
        for (int i = -2; i <= 2; ++i)
          for (int j = -2; j <= 2; ++j)
            best = std::min(best, at(point, worldFromBall, about.theta + i * cell, about.phi + j * cell), nearer);
        better = best.distance < about.distance;
      }
  const double distance = std::min_element(all.begin(), all.end(), nearer)->distance;
  const glm::dvec3 own(glm::inverse(worldFromBall) * glm::dvec4(point, 1.0));
  return glm::length(own) < 1.0 ? -distance : distance;
}

}  // namespace overcast::reference
