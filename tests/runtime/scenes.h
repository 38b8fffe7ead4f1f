// Scenes: small local volumes and random placements for the tests of the passes.
#pragma once

#include <functional>
#include <random>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "formats/asset.h"
#include "runtime/vulkan/resources.h"
#include "tests/reference/pyramid.h"

namespace overcast::test {

/// `distance` sampled over the cube [-half, half]^3 with `samples` samples along each side.
Volume sampled(const std::function<double(const glm::dvec3&)>& distance, int samples, double half);

/// Signed distances of closed forms about the origin.
double sphereDistance(const glm::dvec3& p, double radius);
double boxDistance(const glm::dvec3& p, const glm::dvec3& half);
double torusDistance(const glm::dvec3& p, double ring, double tube);

/// Volumes of different sizes and manners: sphere, box, torus, one cut off by its own box (negative border), one of steep noise, and one
/// that is no cube.
std::vector<Volume> variedVolumes();

/// A heightfield of waves, turned and moved, half rough; single sided or a pair.
HeightField bumps(const glm::ivec2& size, bool pair);

/// These volumes first, then primitives of both shapes, radius fields, heightfields and the volumes again in 8 bits.
std::vector<Asset> variedAssets();

/// Rotation, translation within `spread` of the origin, scale from 0.2 to 2.5 along each axis: uniform, non-uniform, mirrored, or sheared.
glm::dmat4 randomTransform(std::mt19937& random, double spread);

/// A field as an R16F volume in layout GENERAL, as the composite leaves it, and back. They stop the program when the device fails.
GpuImage uploadField(const Device& device, const reference::Field& field);
reference::Field readField(const Device& device, const GpuImage& image);

}  // namespace overcast::test
