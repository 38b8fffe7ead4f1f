// The surfel pass: places the discs of all objects, and finds their accessibility and light (surfels.h). A screen pass of
// surfels.comp.glsl then lights the pixels.
#pragma once

#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "runtime/passes/surfels/surfels.h"
#include "runtime/scene.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// Leaves of one mesh's tree at most: finer meshes have leaves that stand for several vertices.
inline constexpr std::size_t kMostSurfels = 2048;
/// The longest edge between discs, as a share of the longest side of the scene.
inline constexpr double kSurfelEdgeShare = 1.0 / 48.0;

struct SurfelPass {
  GpuBuffer nodes;                            ///< shared::Surfel of all meshes' trees, local space about the mesh's centre
  GpuBuffer objects;                          ///< shared::SurfelObject, mapped
  GpuBuffer placed;                           ///< shared::Surfel of all objects
  GpuBuffer lights;                           ///< vec4 for each placed node: rgb light from others, a accessibility
  std::vector<shared::SurfelObject> records;  ///< one for each object: the runs of nodes
  double nearness = 0.0;
  std::uint32_t placedCount = 0;
  std::uint32_t largestTree = 0;
  Pipeline place;
  Pipeline access;
  Pipeline bounce;
  DescriptorSet placeSet;
  DescriptorSet accessSet;
  DescriptorSet bounceSet;
};

/// Builds the trees of all meshes of `scene`; `nearness`: TechniqueSettings::surfelNearness. Waits for the device. An Error when it cannot
/// hold the nodes.
Result<SurfelPass> makeSurfelPass(const Device& device, const RuntimeScene& scene, double nearness);
void destroySurfelPass(const Device& device, SurfelPass& pass);

/// Places the trees by each object's `worldFromCentre` (its mesh's centred space), seen from `eye`, and records what gives every node its
/// accessibility and light under a sky of `skyColour`. The device must not be reading an earlier frame's.
void recordSurfels(VkCommandBuffer commands, SurfelPass& pass, std::span<const glm::dmat4> worldFromCentre, const glm::dvec3& eye,
                   const glm::vec3& skyColour);

/// The push constants of a walk over `placed` nodes, entering those nearer than `nearness` radii.
shared::SurfelPush surfelPush(std::uint32_t placed, double nearness, const glm::mat4& relativeFromClip, const glm::vec3& skyColour);

}  // namespace overcast
