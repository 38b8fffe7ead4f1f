// A baked scene made of shapes in closed form, written with `formats` alone: what the runtime is tested on without the baker.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>

#include "formats/files.h"
#include "formats/scene.h"
#include "formats/volume.h"
#include "tests/reference/shapes.h"

namespace overcast::test {

/// phi on a grid of `resolution` samples along the longest side of `box`, padded by two voxels.
inline Volume sampledVolume(const Box& box, int resolution, const std::function<double(const glm::dvec3&)>& phi) {
  const glm::dvec3 sides = extent(box);
  Volume volume;
  volume.voxelSize = std::max({sides.x, sides.y, sides.z}) / (resolution - 5);
  volume.origin = box.min - 2.0 * volume.voxelSize;
  volume.size = glm::ivec3(glm::ceil(sides / volume.voxelSize)) + 5;
  volume.signMethod = "closed-form";
  for (int k = 0; k < volume.size.z; ++k)
    for (int j = 0; j < volume.size.y; ++j)
      for (int i = 0; i < volume.size.x; ++i)
        volume.distance.push_back(static_cast<float>(phi(volume.origin + volume.voxelSize * glm::dvec3(i, j, k))));
  return volume;
}

/// Writes `volume` as folder/name.vdb and describes it.
inline Occluder writeOccluder(const std::filesystem::path& folder, const std::string& name, const Volume& volume) {
  Occluder occluder;
  occluder.uri = name + ".vdb";
  const std::filesystem::path file = folder / occluder.uri;
  occluder.bytes = writeVolume(file, volume).value();
  occluder.contentHash = contentHash(readFile(file).value());
  occluder.bounds = bounds(volume);
  occluder.lipschitz = lipschitzBound(volume);
  occluder.influenceRadius = 1.0;
  occluder.signMethod = volume.signMethod;
  occluder.source = name;
  occluder.settingsHash = occluder.contentHash;
  return occluder;
}

/// What writeBakedScene makes: a floor (top at y = 0), a sphere of radius 0.5 at (-0.7, 0.5, 0), and two boxes that share mesh and volume:
/// one turned, one mirrored and stretched.
struct BakedSceneSettings {
  bool animated = false;  ///< the sphere rises and comes back within 2 s
  bool camera = false;
  int resolution = 48;  ///< of the global volume
};

inline Scene bakedScene(const std::filesystem::path& folder, const BakedSceneSettings& settings) {
  using reference::boxMesh;
  Scene scene;
  scene.materials = {{"floor", {0.75f, 0.73f, 0.70f, 1.0f}}, {"red", {0.80f, 0.25f, 0.18f, 1.0f}}, {"blue", {0.25f, 0.40f, 0.75f, 1.0f}}};
  const glm::dvec3 floorHalf(2.0, 0.1, 2.0), boxHalf(0.35, 0.35, 0.35);
  scene.meshes = {boxMesh(floorHalf), reference::icosphere(0.5, 3), boxMesh(boxHalf)};
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    scene.meshes[i].name = i == 0 ? "floor" : i == 1 ? "sphere" : "box";
    scene.meshes[i].parts = {{0, static_cast<std::uint32_t>(scene.meshes[i].triangles.size()), static_cast<int>(i)}};
  }
  const Occluder floor = writeOccluder(folder, "floor",
                                       sampledVolume({-floorHalf, floorHalf + glm::dvec3(0.0, 1.2, 0.0)}, 48,
                                                     [&](const glm::dvec3& p) { return reference::boxDistance(p, floorHalf); }));
  const Occluder sphere = writeOccluder(folder, "sphere", sampledVolume({glm::dvec3(-0.5), glm::dvec3(0.5)}, 24, [](const glm::dvec3& p) {
                                          return reference::sphereDistance(p, 0.5);
                                        }));
  const Occluder box = writeOccluder(
      folder, "box", sampledVolume({-boxHalf, boxHalf}, 24, [&](const glm::dvec3& p) { return reference::boxDistance(p, boxHalf); }));
  const auto place = [&](const std::string& name, int mesh, const glm::dvec3& at, const Occluder& occluder) -> Node& {
    Node& node = scene.nodes.emplace_back();
    node.name = name;
    node.mesh = mesh;
    node.translation = at;
    node.occluder = occluder;
    return node;
  };
  place("floor", 0, {0.0, -0.1, 0.0}, floor);
  place("sphere", 1, {-0.7, 0.5, 0.0}, sphere);
  place("turned", 2, {0.6, 0.35, -0.3}, box).rotation = glm::angleAxis(0.6, glm::dvec3(0, 1, 0));
  place("mirrored", 2, {0.5, 0.175, 0.8}, box).scale = {-0.7, 0.5, 0.6};
  if (settings.animated) {
    AnimationChannel channel;
    channel.node = 1;
    channel.times = {0.0, 1.0, 2.0};
    channel.values = {{-0.7, 0.5, 0.0, 0.0}, {-0.7, 1.1, 0.0, 0.0}, {-0.7, 0.5, 0.0, 0.0}};
    scene.animations.push_back({"rise", {channel}});
  }
  if (settings.camera) {
    scene.cameras.push_back({"above", 0.7, 0.05});
    Node& node = scene.nodes.emplace_back();
    node.name = "camera";
    node.camera = 0;
    node.translation = {0.0, 5.0, 0.0};
    node.rotation = glm::angleAxis(-std::acos(0.0), glm::dvec3(1, 0, 0));
  }
  scene.lighting = Lighting{};
  scene.lighting->globalVolume.resolution = settings.resolution;
  return scene;
}

/// Writes that scene and its volumes into `folder`; the .gltf file.
inline std::filesystem::path writeBakedScene(const std::filesystem::path& folder, const BakedSceneSettings& settings = {}) {
  const std::filesystem::path file = folder / "scene.gltf";
  const auto written = writeScene(file, bakedScene(folder, settings));
  OVERCAST_REQUIRE(written.ok(), "{}", message(written.error()));
  return file;
}

}  // namespace overcast::test
