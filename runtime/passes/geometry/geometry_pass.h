// The geometry pass: rasterises placed meshes into depth, normal and base colour (geometry.h has the formulas).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "runtime/aperture_map.h"
#include "runtime/passes/geometry/geometry.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// What the geometry pass writes and the passes after it read; all sampled in layout SHADER_READ_ONLY_OPTIMAL after
/// recordGeometry.
struct GeometryImages {
  GpuImage depth;   ///< D32: reversed and infinite: near plane / distance along the view axis; 0 where there is no surface
  GpuImage normal;  ///< RGBA16F: xyz unit world-space normal towards the viewer; w 1 on surfaces, else 0
  GpuImage colour;  ///< RGBA8 sRGB (linear when sampled): base colour; a 1 on surfaces
  /// RG32UI: the interpolated aperture in world space and its ambient visibility, in the 8-byte packing of formats/shared/aperture.h; 0
  /// where there is no surface. Null in scenes without apertures.
  GpuImage aperture;
  /// RGBA16F: rgb sky light by the vertices' transfer, irradiance / pi; a 1 on surfaces that have it, else 0. Null in scenes without.
  GpuImage skyLight;
  /// RG16F: the interpolated sky visibility at rest and the trust in apertures (runtime/rest_visibility.h); null where nobody asks for it.
  GpuImage rest;
};

/// What a scene has beside vertices and indices.
struct GeometryExtras {
  bool apertures = false;
  bool transfer = false;  ///< with apertures only
  bool rest = false;      ///< with apertures only
};

/// Sky visibility at rest.
struct RestBuffers {
  GpuBuffer values;     ///< a float for each vertex of each instance, [0, 1]
  GpuBuffer instances;  ///< a shared::RestInstance for each instance
};

Result<GeometryImages> makeGeometryImages(const Device& device, VkExtent2D size, const GeometryExtras& extras = {});
void destroyGeometryImages(const Device& device, GeometryImages& images);

/// A run of indices drawn for a run of instances.
struct GeometryDraw {
  std::uint32_t firstIndex = 0;
  std::uint32_t indexCount = 0;
  std::int32_t vertexOffset = 0;
  std::uint32_t firstInstance = 0;
  std::uint32_t instanceCount = 0;
  int map = -1;  ///< of the pass: the aperture map over these vertices; -1: they have apertures of their own, or none
  glm::vec4 baseColour{1.0f};
};

struct GeometryPass {
  Pipeline pipeline;
  DescriptorSet set;
  Pipeline mapped;                  ///< for draws with a map; null without maps
  std::vector<DescriptorSet> maps;  ///< one for each
  VkSampler sampler = VK_NULL_HANDLE;
  GpuBuffer instances;  ///< shared::GeometryInstance[capacity], mapped
  GpuBuffer transfers;  ///< shared::TransferInstance[capacity], mapped; null without transfer
  VkBuffer indices = VK_NULL_HANDLE;
  std::uint32_t capacity = 0;
};

/// Draws from `vertices` (shared::kVertexFloats floats each) and `indices` (uint32), which must outlive the pass, as must `apertures` (an
/// uvec2 for each vertex, the 8-byte packing of formats/shared/aperture.h, or two floats: the texture coordinates of vertices that are
/// drawn with one of `maps`). Without those (a null buffer) images without apertures are drawn, and nothing is spent on them. The same
/// holds of `transfer`, the 9 floats of VertexVisibility::transfer of all meshes that have them, of `maps`, and of `rest`, which are there
/// with apertures only.
Result<GeometryPass> makeGeometryPass(const Device& device, const GpuBuffer& vertices, const GpuBuffer& indices, std::uint32_t capacity,
                                      const GpuBuffer& apertures = {}, const GpuBuffer& transfer = {},
                                      std::span<const ApertureMapImages> maps = {}, const RestBuffers& rest = {});
void destroyGeometryPass(const Device& device, GeometryPass& pass);

/// The record of a mesh placed by `worldFromLocal` (affine, any determinant, singular ones too) and seen from `eye`, both in world space.
shared::GeometryInstance geometryInstance(const glm::dmat4& worldFromLocal, const glm::dvec3& eye);

/// Puts `instances` and, of a pass with transfer, as many `transfers` into the pass (the device must not be reading an earlier frame's) and
/// records the draws. Outside of rendering.
void recordGeometry(VkCommandBuffer commands, GeometryPass& pass, const GeometryImages& images,
                    std::span<const shared::GeometryInstance> instances, std::span<const GeometryDraw> draws,
                    const glm::mat4& clipFromRelative, std::span<const shared::TransferInstance> transfers = {});

}  // namespace overcast
