#include "data/make/scatter.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include "data/make/shapes.h"
#include "data/make/stage.h"

namespace overcast {
namespace {

struct Sphere {
  glm::dvec3 centre;
  double radius;
};

// Shrinks a mesh into the sphere of `radius` about its origin, touching it.
Mesh fitted(Mesh mesh, double radius) {
  double furthest = 0.0;
  for (const glm::dvec3& position : mesh.positions) furthest = std::max(furthest, glm::length(position));
  for (glm::dvec3& position : mesh.positions) position = snapped(position * (radius / furthest));
  return mesh;
}

ShapeSet addShapes(Scene& scene, Random& random, double radius, std::vector<Mesh> meshes) {
  ShapeSet shapes{{}, radius};
  for (Mesh& mesh : meshes) {
    const int material = addMaterial(scene, mesh.name, clayColour(random));
    shapes.meshes.push_back(addMesh(scene, fitted(std::move(mesh), radius), material));
  }
  return shapes;
}

glm::dquat anyRotation(Random& random) {
  // Shoemake's subgroup method: uniform over all rotations.
  const double u = uniform(random), a = 2.0 * std::numbers::pi * uniform(random), b = 2.0 * std::numbers::pi * uniform(random);
  const double s = std::sqrt(1.0 - u), c = std::sqrt(u);
  return {c * std::cos(b), s * std::sin(a), s * std::cos(a), c * std::sin(b)};
}

bool isFree(const std::vector<Sphere>& taken, const Sphere& sphere) {
  return std::all_of(taken.begin(), taken.end(), [&](const Sphere& other) {
    const double reach = sphere.radius + other.radius;
    const glm::dvec3 between = sphere.centre - other.centre;
    return glm::dot(between, between) > reach * reach;
  });
}

struct Placer {
  Scene& scene;
  Random& random;
  const ShapeSet& shapes;
  const ScatterRegion& region;
  std::vector<Sphere> taken;
};

// One attempt; false where there is no room.
bool placeOnGround(Placer& placer, int number) {
  const ScatterRegion& region = placer.region;
  const int mesh = placer.shapes.meshes[index(placer.random, placer.shapes.meshes.size())];
  const double scale = uniform(placer.random, region.smallest, 1.0), radius = scale * placer.shapes.radius;
  const double x = uniform(placer.random, region.min.x + radius, region.max.x - radius);
  const double z = uniform(placer.random, region.min.y + radius, region.max.y - radius);
  const glm::dquat rotation = turned(uniform(placer.random, 0.0, 360.0), kUp);
  const double lowest = scale * lowestPoint(placer.scene.meshes[static_cast<std::size_t>(mesh)], rotation);
  const Sphere sphere{{x, -lowest, z}, radius};
  if (!isFree(placer.taken, sphere)) return false;
  placer.taken.push_back(sphere);
  const int node = addNode(placer.scene, "standing_" + std::to_string(number), mesh, {sphere.centre, rotation});
  placer.scene.nodes[static_cast<std::size_t>(node)].scale = glm::dvec3(snapped(scale));
  if (uniform(placer.random) < region.movingShare) spin(placer.scene, node, kUp, uniform(placer.random) < 0.5 ? 360.0 : -360.0, 4);
  return true;
}

bool placeInAir(Placer& placer, int number) {
  const ScatterRegion& region = placer.region;
  const int mesh = placer.shapes.meshes[index(placer.random, placer.shapes.meshes.size())];
  const double scale = uniform(placer.random, region.smallest, 1.0), radius = scale * placer.shapes.radius;
  const bool moves = uniform(placer.random) < region.movingShare, rises = moves && uniform(placer.random) < 0.5;
  // What rises and falls needs a taller place: it goes by half a radius to both sides of its middle.
  const double half = rises ? 1.5 * radius : radius;
  if (2.0 * half >= region.top) return false;
  const glm::dvec3 middle(uniform(placer.random, region.min.x + radius, region.max.x - radius),
                          uniform(placer.random, half, region.top - half),
                          uniform(placer.random, region.min.y + radius, region.max.y - radius));
  const Sphere sphere{middle, half};
  if (!isFree(placer.taken, sphere)) return false;
  placer.taken.push_back(sphere);
  const int node = addNode(placer.scene, "flying_" + std::to_string(number), mesh, {middle, anyRotation(placer.random)});
  placer.scene.nodes[static_cast<std::size_t>(node)].scale = glm::dvec3(snapped(scale));
  if (rises) {
    swing(placer.scene, node, 0.5 * radius * kUp, uniform(placer.random), 16);
  } else if (moves) {
    const glm::dvec3 axis(uniform(placer.random, -1.0, 1.0), 1.0, uniform(placer.random, -1.0, 1.0));
    spin(placer.scene, node, axis, uniform(placer.random) < 0.5 ? 360.0 : -360.0, 4);
  }
  return true;
}

}  // namespace

ShapeSet addClutterShapes(Scene& scene, Random& random, double radius) {
  return addShapes(scene, random, radius,
                   {makeIcosphere(1.0, 2), makeBox(glm::dvec3(1.0)), makeBox({1.6, 0.2, 0.6}), makeBox({0.4, 1.5, 0.4}),
                    makeTorus(0.75, 0.25, 20, 7), makeCone(0.6, 1.3, 20), makeCylinder(0.55, 1.0, 20)});
}

ShapeSet addRandomShapes(Scene& scene, Random& random, double radius) {
  std::vector<Mesh> meshes;
  while (meshes.size() < 8) {
    const double a = logUniform(random, 0.15, 1.0), b = logUniform(random, 0.15, 1.0);
    switch (index(random, 7)) {
      case 0:
        meshes.push_back(makeIcosphere(1.0, 3));
        break;
      case 1:
        meshes.push_back(makeBox({1.0, a, b}));
        break;
      case 2:
        meshes.push_back(makeTorus(1.0, std::min(0.5 * a, 0.45), 48, 20));
        break;
      case 3:
        meshes.push_back(makeCone(a, b, 48));
        break;
      case 4:
        meshes.push_back(makeCylinder(a, b, 48));
        break;
      case 5:
        meshes.push_back(makeTorusKnot(1.0, uniform(random, 0.1, 0.22), 2, 3, 160, 12));
        break;
      default:
        meshes.push_back(makeStar(1.0, 3 + static_cast<int>(index(random, 5)), 72, 36));
        break;
    }
  }
  return addShapes(scene, random, radius, std::move(meshes));
}

int scatter(Scene& scene, Random& random, const ShapeSet& shapes, const ScatterRegion& region, int count) {
  constexpr int kAttempts = 400;
  Placer placer{scene, random, shapes, region, {}};
  const glm::dvec2 sides = region.max - region.min;
  const double covered = std::numbers::pi * shapes.radius * shapes.radius;
  const int onGround = std::min(static_cast<int>(region.groundShare * count), static_cast<int>(sides.x * sides.y / (3.0 * covered)));
  int placed = 0;
  for (int i = 0; i < count; ++i) {
    bool found = false;
    for (int attempt = 0; attempt < kAttempts && !found; ++attempt)
      found = i < onGround ? placeOnGround(placer, placed) : placeInAir(placer, placed);
    if (found) ++placed;
  }
  return placed;
}

}  // namespace overcast
