#include <utility>

#include "data/make/random.h"
#include "data/make/scenes.h"
#include "data/make/shapes.h"
#include "data/make/stage.h"

namespace overcast {
namespace {

constexpr double kGoldenAngle = 137.50776405003785;

// A tuft of blades that lean outwards, one mesh.
Mesh makeTuft(Random& random, int blades, double height) {
  std::vector<Mesh> meshes;
  for (int i = 0; i < blades; ++i) {
    const glm::dquat around = turned(kGoldenAngle * i, kUp);
    const glm::dquat lean = turned(-uniform(random, 50.0, 85.0), {1, 0, 0});  // from flat along z towards upright
    const double length = height * uniform(random, 0.6, 1.0);
    meshes.push_back(
        transformed(makeLeaf(length, 0.05, 0.008, 0.006), around * glm::dvec3(0.0, 0.0, uniform(random, 0.01, 0.08)), around * lean));
  }
  return merged(meshes, "tuft");
}

// A stem with leaves round it, the lower ones larger and flatter. Leaves are children of the stem and sway with it.
void addPlant(Scene& scene, Random& random, int stem, const std::vector<int>& leaves, int count, const glm::dvec3& place, double height) {
  const int plant = addNode(scene, "plant", -1, {place});
  // As it sways its foot stays a hair above the ground.
  addChild(scene, plant, addNode(scene, "stem", stem, {{0.0, 0.5 * height + 0.002, 0.0}}));
  for (int i = 0; i < count; ++i) {
    const double share = (i + 0.5) / count;
    const glm::dquat around = turned(kGoldenAngle * i + uniform(random, -15.0, 15.0), kUp);
    const glm::dquat pitch = turned(-(10.0 + 55.0 * share) - uniform(random, -12.0, 12.0), {1, 0, 0});
    const glm::dvec3 at = glm::dvec3(0.0, height * (0.30 + 0.68 * share), 0.0) + around * glm::dvec3(0.0, 0.0, 0.02);
    const int leaf = addNode(scene, "leaf", leaves[index(random, leaves.size())], {at, around * pitch});
    scene.nodes[static_cast<std::size_t>(leaf)].scale = glm::dvec3(snapped(1.15 - 0.5 * share));
    addChild(scene, plant, leaf);
  }
  sway(scene, plant, {uniform(random, -1.0, 1.0), 0.0, uniform(random, -1.0, 1.0)}, 3.0);
}

}  // namespace

Scene makeFoliage() {
  Random random{std::mt19937_64(7)};
  Scene scene = namedScene("foliage");
  addGround(scene, 3.6, 2.8, addMaterial(scene, "earth", {0.62, 0.52, 0.42}));
  const int sage = addMaterial(scene, "sage", {0.50, 0.62, 0.40}), moss = addMaterial(scene, "moss", {0.42, 0.54, 0.34});
  const int lime = addMaterial(scene, "lime", {0.64, 0.70, 0.42}), bark = addMaterial(scene, "bark", {0.52, 0.42, 0.34});
  const int clay = addMaterial(scene, "clay", {0.78, 0.45, 0.32});
  const std::vector<int> leaves = {addMesh(scene, makeLeaf(0.50, 0.20, 0.03, 0.012), sage),
                                   addMesh(scene, makeLeaf(0.44, 0.16, 0.04, 0.012), moss),
                                   addMesh(scene, makeLeaf(0.38, 0.19, 0.02, 0.012), lime)};
  const int tall = addMesh(scene, makeCylinder(0.022, 1.2, 12), bark), low = addMesh(scene, makeCylinder(0.018, 0.8, 12), bark);
  addPlant(scene, random, tall, leaves, 22, {-0.75, 0.0, -0.45}, 1.2);
  addPlant(scene, random, tall, leaves, 22, {0.55, 0.0, -0.55}, 1.2);
  addPlant(scene, random, low, leaves, 14, {-0.10, 0.0, 0.25}, 0.8);
  addPlant(scene, random, low, leaves, 14, {1.15, 0.0, 0.15}, 0.8);
  const int tuft = addMesh(scene, makeTuft(random, 18, 0.38), moss);
  for (const glm::dvec2& at : {glm::dvec2(-1.35, 0.25), {-0.75, 0.75}, {0.55, 0.75}, {1.45, -0.65}, {-1.45, -0.85}, {0.0, -1.0}})
    addNode(scene, "tuft", tuft, {{at.x, 0.0, at.y}, turned(uniform(random, 0.0, 360.0), kUp)});
  const int stone = addMesh(scene, makeIcosphere(0.17, 2), clay);
  standNode(scene, "stone", stone, 0.15, 0.95);
  addCamera(scene, {0.35, 1.75, 3.9}, {0.05, 0.48, -0.05}, 34.0);
  return scene;
}

}  // namespace overcast
