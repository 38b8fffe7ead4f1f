#include "data/make/stage.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include "data/make/shapes.h"

namespace overcast {
namespace {

constexpr double kSlabThickness = 0.25;

double linearFromDisplay(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

glm::dquat snapped(const glm::dquat& q) {
  return {overcast::snapped(q.w), overcast::snapped(q.x), overcast::snapped(q.y), overcast::snapped(q.z)};
}

glm::dvec4 components(const glm::dquat& q) {
  return {q.x, q.y, q.z, q.w};
}

// A channel sampled at keys + 1 equal times; `value` takes the share of the loop in [0, 1].
template <class Value>
void addChannel(Scene& scene, int node, AnimatedProperty property, int keys, const Value& value) {
  if (scene.animations.empty()) scene.animations.push_back({"loop", {}});
  AnimationChannel channel;
  channel.node = node;
  channel.property = property;
  for (int key = 0; key <= keys; ++key) {
    channel.times.push_back(kLoopSeconds * key / keys);
    channel.values.push_back(value(key / double(keys)));
  }
  scene.animations[0].channels.push_back(std::move(channel));
}

template <class Angle>
void turnOverTime(Scene& scene, int node, const glm::dvec3& axis, int keys, const Angle& degrees) {
  const glm::dquat start = scene.nodes[static_cast<std::size_t>(node)].rotation;
  addChannel(scene, node, AnimatedProperty::rotation, keys,
             [&](double share) { return components(snapped(turned(degrees(share), axis) * start)); });
}

}  // namespace

Scene namedScene(const std::string& name) {
  Scene scene;
  scene.name = name;
  return scene;
}

glm::dquat turned(double degrees, const glm::dvec3& axis) {
  const double half = degrees * std::numbers::pi / 360.0;
  const glm::dvec3 xyz = glm::normalize(axis) * std::sin(half);
  return {std::cos(half), xyz.x, xyz.y, xyz.z};
}

int addMaterial(Scene& scene, const std::string& name, const glm::dvec3& colour) {
  Material material;
  material.name = name;
  const glm::dvec3 linear(linearFromDisplay(colour.x), linearFromDisplay(colour.y), linearFromDisplay(colour.z));
  material.baseColour = glm::vec4(glm::vec3(snapped(linear)), 1.0f);
  scene.materials.push_back(material);
  return static_cast<int>(scene.materials.size()) - 1;
}

int addMesh(Scene& scene, Mesh mesh, int material) {
  for (MeshPart& part : mesh.parts) part.material = material;
  scene.meshes.push_back(std::move(mesh));
  return static_cast<int>(scene.meshes.size()) - 1;
}

int addNode(Scene& scene, const std::string& name, int mesh, const Pose& pose) {
  Node node;
  node.name = name;
  node.mesh = mesh;
  node.translation = snapped(pose.translation);
  node.rotation = snapped(pose.rotation);
  scene.nodes.push_back(node);
  return static_cast<int>(scene.nodes.size()) - 1;
}

int standNode(Scene& scene, const std::string& name, int mesh, double x, double z, const glm::dquat& rotation, double ground) {
  const double lowest = lowestPoint(scene.meshes[static_cast<std::size_t>(mesh)], rotation);
  return addNode(scene, name, mesh, {{x, ground - lowest, z}, rotation});
}

void addChild(Scene& scene, int parent, int child) {
  scene.nodes[static_cast<std::size_t>(child)].parent = parent;
  scene.nodes[static_cast<std::size_t>(parent)].children.push_back(child);
}

void addGround(Scene& scene, double width, double depth, int material) {
  const int mesh = addMesh(scene, makeBox({width, kSlabThickness, depth}), material);
  addNode(scene, "ground", mesh, {{0.0, -0.5 * kSlabThickness, 0.0}});
}

void addCamera(Scene& scene, const glm::dvec3& eye, const glm::dvec3& target, double verticalDegrees) {
  Camera camera;
  camera.name = "camera";
  camera.verticalFieldOfView = snapped(verticalDegrees * std::numbers::pi / 180.0);
  scene.cameras.push_back(camera);
  const glm::dvec3 away = eye - target;
  const double heading = std::atan2(away.x, away.z) * 180.0 / std::numbers::pi;
  const double pitch = -std::atan2(away.y, std::hypot(away.x, away.z)) * 180.0 / std::numbers::pi;
  const int node = addNode(scene, "camera", -1, {eye, turned(heading, {0, 1, 0}) * turned(pitch, {1, 0, 0})});
  scene.nodes[static_cast<std::size_t>(node)].camera = static_cast<int>(scene.cameras.size()) - 1;
}

void spin(Scene& scene, int node, const glm::dvec3& axis, double degrees, int keys) {
  turnOverTime(scene, node, axis, keys, [=](double share) { return degrees * share; });
}

void sway(Scene& scene, int node, const glm::dvec3& axis, double degrees) {
  turnOverTime(scene, node, axis, kMotionKeys, [=](double share) { return degrees * std::sin(2.0 * std::numbers::pi * share); });
}

void orbit(Scene& scene, int node, const glm::dvec3& middle, int bobs, double height) {
  const glm::dvec3 start = scene.nodes[static_cast<std::size_t>(node)].translation;
  addChannel(scene, node, AnimatedProperty::translation, kMotionKeys, [&](double share) {
    const glm::dvec3 arm = turned(360.0 * share, {0, 1, 0}) * (start - middle);
    const double rise = 0.5 * height * (1.0 - std::cos(2.0 * std::numbers::pi * bobs * share));
    return glm::dvec4(snapped(middle + arm + glm::dvec3(0.0, rise, 0.0)), 0.0);
  });
}

void swing(Scene& scene, int node, const glm::dvec3& reach, double phase, int keys) {
  const glm::dvec3 middle = scene.nodes[static_cast<std::size_t>(node)].translation;
  addChannel(scene, node, AnimatedProperty::translation, keys,
             [&](double share) { return glm::dvec4(snapped(middle + reach * std::sin(2.0 * std::numbers::pi * (share + phase))), 0.0); });
}

}  // namespace overcast
