#include "runtime/passes/geometry/geometry_pass.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <glm/ext/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "formats/camera.h"
#include "tests/runtime/support.h"

namespace overcast::test {
namespace {

using glm::dmat4;
using glm::dvec3;
using glm::vec3;

constexpr int kWidth = 96;
constexpr int kHeight = 64;

struct Pixel {
  float depth = 0.0f;
  glm::vec4 normal{0.0f};
  glm::u8vec4 colour{0};
};

/// A unit quad (-1 .. 1 in x and y, z = 0, normal +z) that tests place and look at.
class Rasterised : public DeviceTest {
 protected:
  void SetUp() override {
    DeviceTest::SetUp();
    images = makeGeometryImages(device, {kWidth, kHeight}).value();
    setNormals(vec3(0.0f, 0.0f, 1.0f));
  }
  void TearDown() override {
    destroyMesh();
    destroyGeometryImages(device, images);
    DeviceTest::TearDown();
  }
  void destroyMesh() {
    destroyGeometryPass(device, pass);
    destroyBuffer(device, vertices);
    destroyBuffer(device, indices);
  }
  void setNormals(const vec3& n) {
    destroyMesh();
    std::vector<float> data;
    for (const auto& [x, y] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}})
      data.insert(data.end(), {x, y, 0.0f, n.x, n.y, n.z});
    const std::vector<std::uint32_t> corners{0, 1, 2, 0, 2, 3};
    vertices = makeBufferWith(device, std::as_bytes(std::span(data)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT).value();
    indices = makeBufferWith(device, std::as_bytes(std::span(corners)), VK_BUFFER_USAGE_INDEX_BUFFER_BIT).value();
    Result<GeometryPass> made = makeGeometryPass(device, vertices, indices, 4);
    ASSERT_TRUE(made.ok()) << message(made.error());
    pass = std::move(made).value();
  }
  std::vector<Pixel> draw(const std::vector<dmat4>& placed, const View& view) {
    std::vector<shared::GeometryInstance> instances;
    for (const dmat4& worldFromLocal : placed) instances.push_back(geometryInstance(worldFromLocal, eye(view)));
    GeometryDraw all;
    all.indexCount = 6;
    all.instanceCount = static_cast<std::uint32_t>(placed.size());
    all.baseColour = {1.0f, 0.0f, 0.21404114f, 1.0f};  // the last is code 127.5 / 255 in sRGB
    EXPECT_TRUE(runCommands(device, [&](VkCommandBuffer commands) {
                  recordGeometry(commands, pass, images, instances, {&all, 1}, glm::mat4(clipFromRelative(view, double(kWidth) / kHeight)));
                }).ok());
    const auto depth = readImage(device, images.depth, kShaderSample).value();
    const auto normal = readImage(device, images.normal, kShaderSample).value();
    const auto colour = readImage(device, images.colour, kShaderSample).value();
    std::vector<Pixel> pixels(kWidth * kHeight);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      std::memcpy(&pixels[i].depth, depth.data() + 4 * i, 4);
      std::uint64_t packed = 0;
      std::memcpy(&packed, normal.data() + 8 * i, 8);
      pixels[i].normal = glm::unpackHalf4x16(packed);
      std::memcpy(&pixels[i].colour, colour.data() + 4 * i, 4);
    }
    return pixels;
  }
  GeometryImages images;
  GeometryPass pass;
  GpuBuffer vertices;
  GpuBuffer indices;
};

/// The ray of a pixel's centre in view space, z = -1.
dvec3 pixelRay(const View& view, int x, int y) {
  const double tangent = std::tan(0.5 * view.verticalFieldOfView);
  const double aspect = double(kWidth) / kHeight;
  return {tangent * aspect * (2.0 * (x + 0.5) / kWidth - 1.0), -tangent * (2.0 * (y + 0.5) / kHeight - 1.0), -1.0};
}

/// The quad's plane and extent met by the pixel's ray in closed form: distance along the view axis, or none; and how near its edge (0 ..
/// 1).
struct Hit {
  double axial = -1.0;
  double edge = 0.0;
};
Hit meet(const dmat4& worldFromLocal, const View& view, int x, int y) {
  const dmat4 localFromView = glm::inverse(worldFromLocal) * view.worldFromView;
  const dvec3 from(localFromView * glm::dvec4(0, 0, 0, 1));
  const dvec3 along(localFromView * glm::dvec4(pixelRay(view, x, y), 0));
  const double t = -from.z / along.z;
  const dvec3 at = from + t * along;
  return {t, std::max(std::abs(at.x), std::abs(at.y))};
}

TEST_F(Rasterised, DepthNormalAndCoverageAreThoseOfThePlane) {
  const View view = lookAt({0.4, 0.7, 3.0}, {0.1, 0.0, 0.0}, {0, 1, 0}, 0.9);
  const dmat4 placed = glm::rotate(glm::translate(dmat4(1.0), {0.1, -0.2, 0.3}), 0.7, glm::normalize(dvec3(1.0, 2.0, 0.3)));
  const dvec3 normal(placed[2]);
  const std::vector<Pixel> pixels = draw({placed}, view);
  int hits = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Pixel& pixel = pixels[std::size_t(y) * kWidth + std::size_t(x)];
      const Hit hit = meet(placed, view, x, y);
      if (std::abs(hit.edge - 1.0) < 1e-3) continue;
      const bool inside = hit.axial > 0.0 && hit.edge < 1.0;
      ASSERT_EQ(pixel.depth > 0.0f, inside) << x << " " << y;
      ASSERT_EQ(pixel.normal.w, inside ? 1.0f : 0.0f);
      ASSERT_EQ(pixel.colour.w, inside ? 255 : 0);
      if (!inside) continue;
      ++hits;
      ASSERT_NEAR(pixel.depth, view.nearPlane / hit.axial, 2e-6 * view.nearPlane / hit.axial) << x << " " << y;
      ASSERT_LT(glm::length(dvec3(pixel.normal) - normal), 1.5e-3) << "half floats keep 11 bits";
      ASSERT_EQ(pixel.colour.x, 255);
      ASSERT_EQ(pixel.colour.y, 0);
      ASSERT_NEAR(pixel.colour.z, 127.5, 1.0);
    }
  }
  EXPECT_GT(hits, 400);
}

TEST_F(Rasterised, NormalsFaceTheViewerFromBothSidesAndUnderMirroring) {
  const View front = lookAt({0.0, 0.3, 3.0}, {0, 0, 0}, {0, 1, 0}, 0.8);
  const View back = lookAt({0.0, 0.3, -3.0}, {0, 0, 0}, {0, 1, 0}, 0.8);
  const std::size_t middle = std::size_t(kHeight / 2) * kWidth + kWidth / 2;
  for (const vec3& vertexNormal : {vec3(0, 0, 1), vec3(0, 0, -1), vec3(0.0f)}) {
    setNormals(vertexNormal);
    for (const dvec3& scale : {dvec3(1, 1, 1), dvec3(-1, 1, 1), dvec3(1, -2, 1), dvec3(1, 1, -3), dvec3(-1, -1, -1), dvec3(1, 1, 0)}) {
      const dmat4 placed = glm::scale(dmat4(1.0), scale);
      const Pixel fromFront = draw({placed}, front)[middle];
      const Pixel fromBack = draw({placed}, back)[middle];
      ASSERT_GT(fromFront.depth, 0.0f);
      ASSERT_GT(fromBack.depth, 0.0f);
      EXPECT_NEAR(fromFront.normal.z, 1.0f, 1e-3f) << scale.x << scale.y << scale.z << " " << vertexNormal.z;
      EXPECT_NEAR(fromBack.normal.z, -1.0f, 1e-3f) << scale.x << scale.y << scale.z << " " << vertexNormal.z;
    }
  }
}

TEST_F(Rasterised, TheNearerSurfaceWinsWhateverTheOrder) {
  const View view = lookAt({0.0, 0.0, 3.0}, {0, 0, 0}, {0, 1, 0}, 0.8);
  const dmat4 near = glm::translate(dmat4(1.0), {0, 0, 1});
  const dmat4 far = glm::scale(glm::translate(dmat4(1.0), {0, 0, -1}), {2, 2, 2});
  const std::size_t middle = std::size_t(kHeight / 2) * kWidth + kWidth / 2;
  const float nearDepth = static_cast<float>(view.nearPlane / 2.0);
  EXPECT_NEAR(draw({near, far}, view)[middle].depth, nearDepth, 1e-6f * nearDepth);
  EXPECT_NEAR(draw({far, near}, view)[middle].depth, nearDepth, 1e-6f * nearDepth);
}

TEST_F(Rasterised, DetailSurvivesFarFromTheOrigin) {
  const dvec3 away(3.0e6, -2.0e6, 1.0e6);
  const View here = lookAt({0.2, 0.5, 3.0}, {0, 0, 0}, {0, 1, 0}, 0.8);
  View there = here;
  there.worldFromView[3] += glm::dvec4(away, 0.0);
  const std::vector<Pixel> near = draw({dmat4(1.0)}, here);
  const std::vector<Pixel> far = draw({glm::translate(dmat4(1.0), away)}, there);
  for (std::size_t i = 0; i < near.size(); ++i) ASSERT_NEAR(near[i].depth, far[i].depth, 1e-6f * near[i].depth);
}

/// Brute force in double: the normal of a plane is the cross product of two transformed tangents.
RC_GTEST_PROP(GeometryInstance, TurnsNormalsAsItTurnsTangents, ()) {
  const auto number = [] { return *rc::gen::inRange(-1000, 1000) * 0.003; };
  glm::dmat3 linear;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) linear[c][r] = number();
  RC_PRE(std::abs(glm::determinant(linear)) > 0.05);
  const dvec3 n = glm::normalize(dvec3(number() + 0.0011, number(), number()));
  const dvec3 a = glm::normalize(glm::cross(n, std::abs(n.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const dvec3 b = glm::cross(n, a);
  dvec3 expected = glm::normalize(glm::cross(linear * a, linear * b));
  if (glm::dot(expected, linear * n) < 0.0) expected = -expected;  // outside stays outside, mirrored or not
  const shared::GeometryInstance instance = geometryInstance(dmat4(linear), dvec3(0.0));
  const dvec3 got = glm::normalize(
      dvec3(glm::dot(dvec3(instance.normalX), n), glm::dot(dvec3(instance.normalY), n), glm::dot(dvec3(instance.normalZ), n)));
  RC_ASSERT(glm::length(got - expected) < 1e-4);
}

TEST(FacingNormal, FallsBackWhereThereIsNone) {
  const vec3 up(0, 1, 0);
  EXPECT_EQ(shared::facingNormal(vec3(0.0f), -up, up), up);
  EXPECT_EQ(shared::facingNormal(vec3(NAN), up, up), up);
  EXPECT_EQ(shared::facingNormal(vec3(0.0f), vec3(0.0f), 2.0f * up), up);
  const vec3 bent = glm::normalize(vec3(1.0f, -0.1f, 0.2f));  // bends away from the viewer at a silhouette, yet agrees with its face
  EXPECT_LT(glm::length(shared::facingNormal(bent, vec3(1.0f, 0.05f, 0.2f), up) - bent), 1e-6f);
}

}  // namespace
}  // namespace overcast::test
