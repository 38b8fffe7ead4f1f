#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "data/make/scatter.h"
#include "data/make/scenes.h"
#include "data/make/shapes.h"
#include "data/make/stage.h"

namespace overcast {
namespace {

// Everything is laid out over a slab about 4 m wide and then scaled as a whole.
struct Layout {
  Scene scene;
  Random random;
  double halfWidth = 2.0;
  double halfDepth = 2.0;
  std::optional<std::pair<glm::dvec3, glm::dvec3>> view{};  // eye and target; none: from outside, at an angle by chance
};

int clay(Layout& layout) {
  return addMaterial(layout.scene, "clay", clayColour(layout.random));
}

void addSlab(Layout& layout) {
  layout.halfWidth = uniform(layout.random, 1.6, 2.4);
  layout.halfDepth = uniform(layout.random, 1.4, 2.2);
  addGround(layout.scene, 2.0 * layout.halfWidth, 2.0 * layout.halfDepth, clay(layout));
}

void addScatter(Layout& layout, int count, double radius, double top, double groundShare, double front = 1.0) {
  const ShapeSet shapes = addRandomShapes(layout.scene, layout.random, radius);
  const ScatterRegion region{
      {-layout.halfWidth, -layout.halfDepth}, {layout.halfWidth, front * layout.halfDepth}, top, groundShare, 0.5, 0.5};
  scatter(layout.scene, layout.random, shapes, region, count);
}

void layClutter(Layout& layout) {
  addSlab(layout);
  const int count = static_cast<int>(logUniform(layout.random, 6.0, 120.0));
  const double radius = std::min(1.1 / std::cbrt(count), 0.45) * uniform(layout.random, 0.7, 1.0);
  addScatter(layout, count, radius, uniform(layout.random, 0.8, 2.0), uniform(layout.random, 0.3, 1.0));
}

// Blocks on a grid, some on top of others, with lanes between them.
void layBlocks(Layout& layout) {
  addSlab(layout);
  const int columns = 3 + static_cast<int>(index(layout.random, 5)), rows = 3 + static_cast<int>(index(layout.random, 4));
  const double width = 2.0 * layout.halfWidth / columns, depth = 2.0 * layout.halfDepth / rows;
  std::vector<int> blocks;
  std::vector<glm::dvec3> sizes;
  for (int i = 0; i < 6; ++i) {
    sizes.emplace_back(width * uniform(layout.random, 0.4, 0.9), logUniform(layout.random, 0.1, 1.5),
                       depth * uniform(layout.random, 0.4, 0.9));
    blocks.push_back(addMesh(layout.scene, makeBox(sizes.back()), clay(layout)));
  }
  for (int i = 0; i < columns * rows; ++i) {
    const glm::dvec3 middle(-layout.halfWidth + width * (i % columns + 0.5), 0.0, -layout.halfDepth + depth * (i / columns + 0.5));
    double height = 0.0;
    for (int level = 0; level < 2 && uniform(layout.random) < 0.75 - 0.4 * level; ++level) {
      const std::size_t block = index(layout.random, blocks.size());
      standNode(layout.scene, "block", blocks[block], middle.x, middle.z, turned(uniform(layout.random, -8.0, 8.0), kUp), height);
      height += sizes[block].y;
    }
  }
}

// Walls, floor and sometimes a ceiling round clutter; one side is open, or has a window.
void layRoom(Layout& layout) {
  layout.halfWidth = uniform(layout.random, 1.2, 2.2);
  layout.halfDepth = uniform(layout.random, 1.2, 2.2);
  const double height = uniform(layout.random, 1.2, 2.4), t = uniform(layout.random, 0.06, 0.3);
  const int paint = clay(layout), other = clay(layout);
  const glm::dvec3 level(2.0 * (layout.halfWidth + t), t, 2.0 * (layout.halfDepth + t));
  const int slab = addMesh(layout.scene, makeBox(level), paint);
  addNode(layout.scene, "floor", slab, {{0.0, -0.5 * t, 0.0}});
  if (uniform(layout.random) < 0.7) addNode(layout.scene, "ceiling", slab, {{0.0, height + 0.5 * t, 0.0}});
  const int side = addMesh(layout.scene, makeBox({t, height + t, level.z - 0.02}), other);
  addNode(layout.scene, "left", side, {{-layout.halfWidth - 0.49 * t, 0.5 * height, 0.0}});
  if (uniform(layout.random) < 0.8) addNode(layout.scene, "right", side, {{layout.halfWidth + 0.49 * t, 0.5 * height, 0.0}});
  const glm::dvec3 end(level.x - 0.03, height + t, 0.98 * t);
  addNode(layout.scene, "back", addMesh(layout.scene, makeBox(end), paint), {{0.0, 0.5 * height, -layout.halfDepth - 0.48 * t}});
  if (uniform(layout.random) < 0.6) {
    const double sill = uniform(layout.random, 0.05, 0.4) * height, right = uniform(layout.random, 0.2, 0.8) * layout.halfWidth;
    const Mesh frame = makeFrame(end, {-uniform(layout.random, 0.2, 0.8) * layout.halfWidth, sill - 0.5 * height}, {right, 0.4 * height});
    addNode(layout.scene, "front", addMesh(layout.scene, frame, paint), {{0.0, 0.5 * height, layout.halfDepth + 0.48 * t}});
  }
  addScatter(layout, 4 + static_cast<int>(index(layout.random, 16)), uniform(layout.random, 0.15, 0.35), 0.9 * height, 0.8, 0.4);
  const glm::dvec3 eye(uniform(layout.random, -0.7, 0.7) * layout.halfWidth, uniform(layout.random, 0.4, 0.8) * height,
                       0.92 * layout.halfDepth);
  layout.view = std::pair(eye, glm::dvec3(-0.3 * eye.x, 0.3 * height, -0.4 * layout.halfDepth));
}

// Thin walls that stand about, some of them leaning, and clutter between them.
void layWalls(Layout& layout) {
  addSlab(layout);
  for (int i = 3 + static_cast<int>(index(layout.random, 7)); i > 0; --i) {
    const glm::dvec3 size(uniform(layout.random, 0.4, 2.0), uniform(layout.random, 0.3, 1.5), logUniform(layout.random, 0.015, 0.2));
    const int wall = addMesh(layout.scene, makeBox(size), clay(layout));
    const glm::dquat rotation =
        turned(uniform(layout.random, 0.0, 180.0), kUp) * turned(uniform(layout.random) < 0.3 ? 25.0 : 0.0, {1, 0, 0});
    standNode(layout.scene, "wall", wall, uniform(layout.random, -0.8, 0.8) * layout.halfWidth,
              uniform(layout.random, -0.8, 0.8) * layout.halfDepth, rotation);
  }
  addScatter(layout, 5 + static_cast<int>(index(layout.random, 12)), uniform(layout.random, 0.12, 0.3), 1.2, 0.8);
}

// Rods, cards and leaves in the air and on the ground.
void layThinThings(Layout& layout) {
  addSlab(layout);
  const double size = uniform(layout.random, 0.25, 0.6), thin = size * logUniform(layout.random, 0.02, 0.1);
  ShapeSet shapes{{}, 0.6 * size};
  for (const Mesh& mesh :
       {makeBox({size, thin, 0.6 * size}), makeBox({thin, size, thin}), makeCylinder(thin, size, 16), makeBox({size, 0.4 * size, thin}),
        transformed(makeLeaf(size, 0.4 * size, 0.05 * size, thin), {0.0, 0.0, -0.5 * size}, turned(0.0, kUp))})
    shapes.meshes.push_back(addMesh(layout.scene, mesh, clay(layout)));
  const ScatterRegion region{
      {-layout.halfWidth, -layout.halfDepth}, {layout.halfWidth, layout.halfDepth}, uniform(layout.random, 1.0, 1.8), 0.5, 0.5, 0.5};
  // Spheres round thin things waste room: in layers that know nothing of each other they come as close as leaves do.
  for (int layer = 0; layer < 3; ++layer)
    scatter(layout.scene, layout.random, shapes, region, static_cast<int>(logUniform(layout.random, 8.0, 50.0)));
}

void addView(Layout& layout) {
  if (layout.view) {
    addCamera(layout.scene, layout.view->first, layout.view->second, 62.0);
    return;
  }
  const double azimuth = uniform(layout.random, -50.0, 50.0), elevation = uniform(layout.random, 12.0, 45.0);
  const glm::dvec3 target(0.0, uniform(layout.random, 0.2, 0.5), 0.0);
  addCamera(layout.scene, target + turned(azimuth, kUp) * (turned(-elevation, {1, 0, 0}) * glm::dvec3(0.0, 0.0, 6.2)), target, 36.0);
}

// Scales a scene about the origin.
void scaleBy(Scene& scene, double factor) {
  for (Node& node : scene.nodes) {
    node.translation = snapped(node.translation * factor);
    if (node.mesh >= 0) node.scale = glm::dvec3(snapped(node.scale * factor));
  }
  for (Animation& animation : scene.animations)
    for (AnimationChannel& channel : animation.channels)
      if (channel.property == AnimatedProperty::translation)
        for (glm::dvec4& value : channel.values) value = glm::dvec4(snapped(glm::dvec3(value) * factor), 0.0);
}

}  // namespace

Scene makeRandomScene(std::uint64_t seed) {
  constexpr std::array kLayouts = {layClutter, layBlocks, layRoom, layWalls, layThinThings};
  Layout layout{namedScene("random_" + std::to_string(seed)), Random{std::mt19937_64(seed)}};
  kLayouts[index(layout.random, kLayouts.size())](layout);
  addView(layout);
  scaleBy(layout.scene, logUniform(layout.random, 0.1, 10.0));
  return std::move(layout.scene);
}

}  // namespace overcast
