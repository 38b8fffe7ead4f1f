// Where the nodes of a scene are at a time (glTF 2.0, 3.5 and 3.11, Appendix C).
#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "formats/scene.h"

namespace overcast {
namespace {

constexpr int kBoundsSamples = 64;

glm::dquat rotationOf(const glm::dvec4& v) {
  return glm::dquat(v.w, v.x, v.y, v.z);
}

glm::dvec4 normalised(const glm::dvec4& v) {
  const double length = glm::length(v);
  return length > 0.0 ? v / length : glm::dvec4(0.0, 0.0, 0.0, 1.0);
}

/// Appendix C.4: u in [0, 1] between keys `key` and `key` + 1, which are `seconds` apart.
glm::dvec4 cubicSpline(const AnimationChannel& channel, std::size_t key, double u, double seconds) {
  const glm::dvec4* k = &channel.values[3 * key];
  const double u2 = u * u;
  const double u3 = u2 * u;
  return (2.0 * u3 - 3.0 * u2 + 1.0) * k[1] + seconds * (u3 - 2.0 * u2 + u) * k[2] + (3.0 * u2 - 2.0 * u3) * k[4] +
         seconds * (u3 - u2) * k[3];
}

glm::dvec4 sample(const AnimationChannel& channel, double time) {
  const bool cubic = channel.interpolation == Interpolation::cubicSpline;
  const bool rotation = channel.property == AnimatedProperty::rotation;
  const auto value = [&](std::size_t key) { return channel.values[cubic ? 3 * key + 1 : key]; };
  const auto after = std::upper_bound(channel.times.begin(), channel.times.end(), time);
  if (after == channel.times.begin()) return value(0);
  if (after == channel.times.end()) return value(channel.times.size() - 1);
  const auto key = static_cast<std::size_t>(after - channel.times.begin()) - 1;
  const double seconds = channel.times[key + 1] - channel.times[key];
  const double u = (time - channel.times[key]) / seconds;
  if (channel.interpolation == Interpolation::step) return value(key);
  if (cubic) return rotation ? normalised(cubicSpline(channel, key, u, seconds)) : cubicSpline(channel, key, u, seconds);
  if (!rotation) return glm::mix(value(key), value(key + 1), u);
  const glm::dquat between = glm::slerp(rotationOf(value(key)), rotationOf(value(key + 1)), u);
  return {between.x, between.y, between.z, between.w};
}

double inLoop(double time, double duration) {
  return duration > 0.0 ? time - std::floor(time / duration) * duration : 0.0;
}

glm::dmat4 parentFromLocal(const Node& node) {
  if (node.matrix) return *node.matrix;
  const glm::dmat4 placed = glm::translate(glm::dmat4(1.0), node.translation) * glm::mat4_cast(node.rotation);
  return glm::scale(placed, node.scale);
}

/// Every node's own transform at `time`, animations applied.
std::vector<glm::dmat4> localTransforms(const Scene& scene, double time) {
  std::vector<glm::dmat4> transforms;
  transforms.reserve(scene.nodes.size());
  for (const Node& node : scene.nodes) transforms.push_back(parentFromLocal(node));
  std::vector<std::size_t> slot(scene.nodes.size(), 0);
  std::vector<Node> moved;
  for (const Animation& animation : scene.animations) {
    for (const AnimationChannel& channel : animation.channels) {
      const auto index = static_cast<std::size_t>(channel.node);
      OVERCAST_REQUIRE(index < scene.nodes.size(), "channel moves node {} of {}", channel.node, scene.nodes.size());
      if (scene.nodes[index].matrix) continue;
      if (slot[index] == 0) {
        const Node& still = scene.nodes[index];
        moved.push_back({"", -1, {}, std::nullopt, still.translation, still.rotation, still.scale, -1, -1, std::nullopt});
        slot[index] = moved.size();
      }
      Node& node = moved[slot[index] - 1];
      const glm::dvec4 value = sample(channel, time);
      if (channel.property == AnimatedProperty::translation) node.translation = glm::dvec3(value);
      if (channel.property == AnimatedProperty::rotation) node.rotation = rotationOf(value);
      if (channel.property == AnimatedProperty::scale) node.scale = glm::dvec3(value);
    }
  }
  for (std::size_t i = 0; i < slot.size(); ++i)
    if (slot[i] != 0) transforms[i] = parentFromLocal(moved[slot[i] - 1]);
  return transforms;
}

/// Positions that triangles use, each once.
std::vector<glm::dvec3> usedPositions(const Mesh& mesh) {
  std::vector<bool> used(mesh.positions.size(), false);
  for (const glm::uvec3& triangle : mesh.triangles)
    for (int c = 0; c < 3; ++c) used[triangle[c]] = true;
  std::vector<glm::dvec3> positions;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) positions.push_back(mesh.positions[i]);
  return positions;
}

}  // namespace

std::vector<char> movingNodes(const Scene& scene) {
  std::vector<char> animated(scene.nodes.size(), 0), moving(scene.nodes.size(), 0);
  for (const Animation& animation : scene.animations)
    for (const AnimationChannel& channel : animation.channels) animated[static_cast<std::size_t>(channel.node)] = 1;
  for (std::size_t n = 0; n < scene.nodes.size(); ++n)
    for (int node = static_cast<int>(n); node >= 0 && !moving[n]; node = scene.nodes[static_cast<std::size_t>(node)].parent)
      moving[n] = animated[static_cast<std::size_t>(node)];
  return moving;
}

double animationDuration(const Scene& scene) {
  double duration = 0.0;
  for (const Animation& animation : scene.animations)
    for (const AnimationChannel& channel : animation.channels)
      if (!channel.times.empty()) duration = std::max(duration, channel.times.back());
  return duration;
}

std::vector<glm::dmat4> worldFromLocal(const Scene& scene, double time, bool loop) {
  std::vector<glm::dmat4> transforms = localTransforms(scene, loop ? inLoop(time, animationDuration(scene)) : time);
  std::vector<bool> done(scene.nodes.size(), false);
  std::vector<std::size_t> chain;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    for (std::size_t node = i; !done[node];) {
      OVERCAST_REQUIRE(chain.size() < scene.nodes.size(), "node {} is its own ancestor", i);
      chain.push_back(node);
      if (scene.nodes[node].parent < 0) break;
      node = static_cast<std::size_t>(scene.nodes[node].parent);
    }
    for (; !chain.empty(); chain.pop_back()) {
      const std::size_t node = chain.back();
      const int parent = scene.nodes[node].parent;
      if (parent >= 0) transforms[node] = transforms[static_cast<std::size_t>(parent)] * transforms[node];
      done[node] = true;
    }
  }
  return transforms;
}

Box worldBounds(const Scene& scene) {
  std::vector<std::vector<glm::dvec3>> positions;
  for (const Mesh& mesh : scene.meshes) positions.push_back(usedPositions(mesh));
  const double duration = animationDuration(scene);
  const int samples = duration > 0.0 ? kBoundsSamples : 1;
  Box box;
  std::vector<glm::dmat4> last;
  for (int s = 0; s < samples; ++s) {
    const double time = samples > 1 ? duration * s / (samples - 1) : 0.0;
    const std::vector<glm::dmat4> transforms = worldFromLocal(scene, time, false);
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
      if (scene.nodes[i].mesh < 0 || (!last.empty() && last[i] == transforms[i])) continue;
      for (const glm::dvec3& p : positions[static_cast<std::size_t>(scene.nodes[i].mesh)])
        include(box, glm::dvec3(transforms[i] * glm::dvec4(p, 1.0)));
    }
    last = transforms;
  }
  return box;
}

}  // namespace overcast
