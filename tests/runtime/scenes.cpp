#include "tests/runtime/scenes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tests/formats/radius_fields.h"

namespace overcast::test {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  // Not std::uniform_real_distribution, whose values depend on the standard library.
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

glm::dmat4 scaling(const glm::dvec3& scale) {
  glm::dmat4 matrix(1.0);
  for (int axis = 0; axis < 3; ++axis) matrix[axis][axis] = scale[axis];
  return matrix;
}

glm::dmat4 randomRotation(std::mt19937& random) {
  const glm::dquat q{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
  return glm::mat4_cast(glm::normalize(q));
}

}  // namespace

Volume sampled(const std::function<double(const glm::dvec3&)>& distance, int samples, double half) {
  Volume volume;
  volume.size = glm::ivec3(samples);
  volume.origin = glm::dvec3(-half);
  volume.voxelSize = 2.0 * half / (samples - 1);
  for (int k = 0; k < samples; ++k)
    for (int j = 0; j < samples; ++j)
      for (int i = 0; i < samples; ++i)
        volume.distance.push_back(static_cast<float>(distance(volume.origin + volume.voxelSize * glm::dvec3(i, j, k))));
  return volume;
}

double sphereDistance(const glm::dvec3& p, double radius) {
  return glm::length(p) - radius;
}

double boxDistance(const glm::dvec3& p, const glm::dvec3& half) {
  const glm::dvec3 beyond = glm::abs(p) - half;
  return glm::length(glm::max(beyond, glm::dvec3(0.0))) + std::min(std::max({beyond.x, beyond.y, beyond.z}), 0.0);
}

double torusDistance(const glm::dvec3& p, double ring, double tube) {
  return std::hypot(std::hypot(p.x, p.z) - ring, p.y) - tube;
}

std::vector<Volume> variedVolumes() {
  std::vector<Volume> volumes;
  volumes.push_back(sampled([](const glm::dvec3& p) { return sphereDistance(p, 0.8); }, 16, 1.0));
  volumes.push_back(sampled([](const glm::dvec3& p) { return boxDistance(p, {0.7, 0.3, 0.5}); }, 12, 0.9));
  volumes.push_back(sampled([](const glm::dvec3& p) { return torusDistance(p, 0.6, 0.2); }, 20, 1.0));
  volumes.push_back(sampled([](const glm::dvec3& p) { return sphereDistance(p, 1.2); }, 9, 1.0));
  std::mt19937 random(7);
  volumes.push_back(sampled([&](const glm::dvec3& p) { return sphereDistance(p, 0.5) + uniform(random, -0.4, 0.4); }, 7, 1.0));
  Volume flat = volumes[1];
  flat.size.z = 5;
  flat.distance.resize(static_cast<std::size_t>(flat.size.x * flat.size.y * flat.size.z));
  volumes.push_back(flat);
  return volumes;
}

HeightField bumps(const glm::ivec2& size, bool pair) {
  HeightField field;
  field.size = size;
  field.halfExtent = {0.9, 0.9 * size.y / size.x, 0.5};
  field.origin = {0.1, 0.0, -0.2};
  field.localFromField = glm::mat3_cast(glm::normalize(glm::dquat(0.7, -0.3, 0.2, 0.4)));
  const auto layer = [&](double middle, double height) {
    std::vector<HeightTexel> texels;
    for (int j = 0; j < size.y; ++j)
      for (int i = 0; i < size.x; ++i) {
        const double wave = std::sin(20.0 * i / size.x) * std::cos(9.0 * j / size.y);
        texels.push_back({static_cast<float>(middle + height * wave), static_cast<float>(1e-3 * (1.0 + wave))});
      }
    return texels;
  };
  field.front = {layer(0.4, 0.2)};
  if (pair) field.back = {layer(-0.4, -0.15)};
  buildLevels(field);
  return asStored(std::move(field));
}

std::vector<Asset> variedAssets() {
  std::vector<Asset> assets;
  for (Volume& volume : variedVolumes()) assets.emplace_back(std::move(volume));
  const glm::dquat turned = glm::normalize(glm::dquat(0.9, 0.2, -0.3, 0.1));
  assets.emplace_back(Primitive{PrimitiveShape::cuboid, {0.1, -0.2, 0.3}, turned, {0.8, 0.3, 0.5}});
  assets.emplace_back(Primitive{PrimitiveShape::cuboid, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}, {0.6, 0.01, 0.4}});
  assets.emplace_back(Primitive{PrimitiveShape::ellipsoid, {-0.1, 0.2, 0.0}, turned, {0.9, 0.2, 0.5}});
  assets.emplace_back(Primitive{PrimitiveShape::ellipsoid, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}, {0.7, 0.7, 0.7}});
  assets.emplace_back(fieldOf(reference::bumpyRadius(), 16, {0.2, 0.0, -0.1}, 0.002f));
  assets.emplace_back(fieldOf(reference::cuboidRadius({0.9, 0.2, 0.4}), 8));
  assets.emplace_back(bumps({32, 16}, false));
  assets.emplace_back(bumps({16, 16}, true));
  for (Volume& volume : variedVolumes()) assets.emplace_back(asStored(std::move(volume), VolumeBits::snorm8));
  return assets;
}

glm::dmat4 randomTransform(std::mt19937& random, double spread) {
  const glm::dvec3 where{uniform(random, -spread, spread), uniform(random, -spread, spread), uniform(random, -spread, spread)};
  glm::dvec3 scale(uniform(random, 0.2, 2.5));
  const unsigned kind = random() % 4;
  if (kind > 0) scale = {uniform(random, 0.2, 2.5), uniform(random, 0.2, 2.5), uniform(random, 0.2, 2.5)};
  if (kind == 2) scale.x = -scale.x;
  glm::dmat4 matrix = randomRotation(random) * scaling(scale);
  if (kind == 3) matrix = matrix * randomRotation(random) * scaling({1.0, 0.6, 1.4});
  matrix[3] = glm::dvec4(where, 1.0);
  return matrix;
}

GpuImage uploadField(const Device& device, const reference::Field& field) {
  ImageSettings settings;
  const glm::uvec3 size(field.size);
  settings.extent = {size.x, size.y, size.z};
  settings.volume = true;
  settings.format = VK_FORMAT_R16_SFLOAT;
  settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT;
  Result<GpuImage> image = makeImage(device, settings);
  OVERCAST_REQUIRE(image.ok(), "{}", message(image.error()));
  std::vector<std::uint16_t> halves;
  for (const double value : field.values) halves.push_back(glm::packHalf1x16(static_cast<float>(value)));
  const Result<Done> uploaded = uploadImage(device, image.value(), std::as_bytes(std::span(halves)), kComputeRead);
  OVERCAST_REQUIRE(uploaded.ok(), "{}", message(uploaded.error()));
  return image.value();
}

reference::Field readField(const Device& device, const GpuImage& image) {
  const Result<std::vector<std::byte>> bytes = readImage(device, image, kComputeWrite);
  OVERCAST_REQUIRE(bytes.ok(), "{}", message(bytes.error()));
  reference::Field field{glm::ivec3(image.extent.width, image.extent.height, image.extent.depth), {}};
  for (std::size_t at = 0; at < bytes.value().size(); at += 2) {
    std::uint16_t half = 0;
    std::memcpy(&half, bytes.value().data() + at, 2);
    field.values.push_back(glm::unpackHalf1x16(half));
  }
  return field;
}

}  // namespace overcast::test
