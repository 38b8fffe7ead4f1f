#include "tests/runtime/ground.h"

#include <algorithm>
#include <cstring>

#include <gtest/gtest.h>
#include <glm/gtc/packing.hpp>

#include "tests/runtime/scenes.h"

namespace overcast::test {

glm::dmat4 clipFromRelative(const GroundView& view) {
  const GlobalGrid& grid = view.grid;
  const glm::dvec3 low = grid.origin + grid.voxelSize * glm::dvec3(view.left) - view.eye;
  const double width = grid.voxelSize * (view.right - view.left);
  const double top = kGroundSide * grid.voxelSize;
  glm::dmat4 clip(0.0);
  clip[0][0] = 2.0 / width;
  clip[2][1] = 2.0 / width;
  clip[1][2] = 1.0 / top;
  clip[3] = glm::dvec4(-1.0 - 2.0 * low.x / width, -1.0 - 2.0 * low.z / width, -(grid.origin.y - view.eye.y) / top, 1.0);
  return clip;
}

glm::dvec2 column(std::size_t n, const GroundView& view) {
  const double step = (view.right - view.left) / kGroundSide;
  return {view.left + step * (static_cast<double>(n % kGroundSide) + 0.5), view.left + step * (static_cast<double>(n / kGroundSide) + 0.5)};
}

GeometryImages uploadGround(const Device& device, const Ground& ground, const GroundView& view) {
  std::vector<float> depths;
  std::vector<std::uint64_t> normals;
  for (std::size_t n = 0; n < kGroundSide * kGroundSide; ++n) {
    const glm::dvec2 at = column(n, view);
    const Surface surface = ground(at.x, at.y);
    depths.push_back(static_cast<float>(surface.height / kGroundSide));
    normals.push_back(glm::packHalf4x16(glm::vec4(surface.normal, 1.0f)));
  }
  const std::vector<std::uint32_t> white(kGroundSide * kGroundSide, 0xffffffffu);
  GeometryImages images = makeGeometryImages(device, {kGroundSide, kGroundSide}).value();
  EXPECT_TRUE(uploadImage(device, images.depth, std::as_bytes(std::span(depths)), kComputeSample).ok());
  EXPECT_TRUE(uploadImage(device, images.normal, std::as_bytes(std::span(normals)), kComputeSample).ok());
  EXPECT_TRUE(uploadImage(device, images.colour, std::as_bytes(std::span(white)), kComputeSample).ok());
  return images;
}

std::vector<Pixel> readPixels(const Device& device, const GpuImage& light) {
  const std::vector<std::byte> bytes = readImage(device, light, kComputeSample).value();
  std::vector<Pixel> pixels(bytes.size() / 8);
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    std::uint64_t packed = 0;
    std::memcpy(&packed, bytes.data() + 8 * n, 8);
    const glm::vec4 value = glm::unpackHalf4x16(packed);
    pixels[n] = {glm::vec3(value), value.w};
  }
  return pixels;
}

reference::Field groundCube(const std::function<double(const glm::dvec3&)>& f) {
  return reference::fieldOf(glm::ivec3(kGroundSide), f);
}

double sphereOnGround(const glm::dvec3& p) {
  return std::min(p.y - kGround, sphereDistance(p - glm::dvec3(32, kGround + kSphereRadius, 32), kSphereRadius));
}

Surface groundOnly(double, double) {
  return {kGround, {0, 1, 0}};
}

}  // namespace overcast::test
