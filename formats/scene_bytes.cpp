#include "formats/scene_bytes.h"

#include "formats/archive.h"
#include "formats/occluder_fields.h"
#include "formats/scene_check.h"

namespace overcast {

template <class Archive>
void fields(Archive& archive, VertexVisibility& visibility) {
  archive(visibility.bits, visibility.apertures, visibility.ambient, visibility.transfer);
}

template <class Archive>
void fields(Archive& archive, ApertureLink& link) {
  archive(link.uri, link.contentHash, link.bytes, link.texCoord, link.sceneOccludes, link.radiusError, link.ambientError,
          link.directionError);
}

template <class Archive>
void fields(Archive& archive, ApertureBake& bake) {
  auto& [rays, sceneOccludes, fitted, samples, seed, radius, ambient, direction] = bake;
  archive(rays, sceneOccludes, fitted, samples, seed, radius, ambient, direction);
}

template <class Archive>
void fields(Archive& archive, MeshLevels& levels) {
  archive(levels.groups, levels.clusters, levels.triangles);
}

template <class Archive>
void fields(Archive& archive, Mesh& mesh) {
  archive(mesh.name, mesh.positions, mesh.normals, mesh.triangles, mesh.parts, mesh.visibility, mesh.textureCoordinates, mesh.apertureMap,
          mesh.apertureBake, mesh.levels);
}

template <class Archive>
void fields(Archive& archive, Material& material) {
  archive(material.name, material.baseColour);
}

template <class Archive>
void fields(Archive& archive, Camera& camera) {
  archive(camera.name, camera.verticalFieldOfView, camera.nearPlane);
}

template <class Archive>
void fields(Archive& archive, Node& node) {
  archive(node.name, node.parent, node.children, node.matrix, node.translation, node.rotation, node.scale, node.mesh, node.camera,
          node.occluder);
}

template <class Archive>
void fields(Archive& archive, AnimationChannel& channel) {
  archive(channel.node, channel.property, channel.interpolation, channel.times, channel.values);
}

template <class Archive>
void fields(Archive& archive, Animation& animation) {
  archive(animation.name, animation.channels);
}

template <class Archive>
void fields(Archive& archive, GlobalVolume& volume) {
  archive(volume.bounds, volume.resolution);
}

template <class Archive>
void fields(Archive& archive, SkyStep& step) {
  archive(step.weights, step.gaps, step.start, step.slant, step.height);
}

template <class Archive>
void fields(Archive& archive, Estimator& estimator) {
  archive(estimator.name, estimator.taps, estimator.k, estimator.skyWeight, estimator.steps, estimator.cones, estimator.fitError,
          estimator.heldOutError);
}

template <class Archive>
void fields(Archive& archive, Lighting& lighting) {
  archive(lighting.skyColour, lighting.skyImage, lighting.up, lighting.sun, lighting.areaLights, lighting.globalVolume, lighting.estimator,
          lighting.exposure);
}

template <class Archive>
void fields(Archive& archive, Scene& scene) {
  archive(scene.name, scene.meshes, scene.materials, scene.cameras, scene.nodes, scene.animations, scene.lighting, scene.notes);
}

std::vector<std::byte> packScene(const Scene& scene) {
  return archived(scene);
}

std::optional<Scene> unpackScene(std::span<const std::byte> bytes) {
  auto scene = unarchived<Scene>(bytes);
  if (scene && !brokenInvariant(*scene).empty()) scene.reset();
  return scene;
}

}  // namespace overcast
