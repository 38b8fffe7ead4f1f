#include "data/make/scenes.h"
#include "data/make/shapes.h"
#include "data/make/stage.h"

namespace overcast {
namespace {

constexpr double kHalfWidth = 2.0, kHalfDepth = 2.5, kHeight = 2.6, kWall = 0.2;

// Floor, ceiling and walls reach into each other, so that their union has no seam; the window is in the wall at -x.
void addShell(Scene& scene) {
  const int plaster = addMaterial(scene, "plaster", {0.88, 0.85, 0.80}), boards = addMaterial(scene, "boards", {0.66, 0.52, 0.40});
  const int rose = addMaterial(scene, "rose", {0.74, 0.50, 0.46});
  const glm::dvec3 level(2.0 * (kHalfWidth + kWall), kWall, 2.0 * (kHalfDepth + kWall));
  addNode(scene, "floor", addMesh(scene, makeBox(level), boards), {{0.0, -0.5 * kWall, 0.0}});
  addNode(scene, "ceiling", addMesh(scene, makeBox(level), plaster), {{0.0, kHeight + 0.5 * kWall, 0.0}});
  // A centimetre less than floor and ceiling, whose sides then stay clear of theirs.
  const double depth = 2.0 * (kHalfDepth + kWall) - 0.02, height = kHeight + kWall, middle = 0.5 * kHeight;
  const glm::dquat facing = turned(90.0, kUp);  // the frame's x runs along -z
  const int window = addMesh(scene, makeFrame({depth, height, kWall - 0.01}, {-0.7, -0.5}, {1.7, 1.0}), plaster);
  addNode(scene, "left", window, {{-kHalfWidth - 0.5 * (kWall - 0.01), middle, 0.0}, facing});
  addNode(scene, "right", addMesh(scene, makeBox({kWall - 0.01, height, depth}), rose), {{kHalfWidth + 0.5 * (kWall - 0.01), middle, 0.0}});
  const int end = addMesh(scene, makeBox({2.0 * (kHalfWidth + kWall) - 0.04, height, kWall - 0.02}), plaster);
  addNode(scene, "back", end, {{0.0, middle, -kHalfDepth - 0.5 * (kWall - 0.02)}});
  addNode(scene, "front", end, {{0.0, middle, kHalfDepth + 0.5 * (kWall - 0.02)}});
}

void addTable(Scene& scene) {
  const int oak = addMaterial(scene, "oak", {0.70, 0.55, 0.38});
  addNode(scene, "table_top", addMesh(scene, makeBox({0.8, 0.05, 1.3}), oak), {{-0.35, 0.725, -0.75}});
  const int leg = addMesh(scene, makeBox({0.06, 0.71, 0.06}), oak);
  for (const double x : {-0.68, -0.02})
    for (const double z : {-1.33, -0.17}) addNode(scene, "leg", leg, {{x, 0.355, z}});
  const int seat = addMesh(scene, makeBox({0.42, 0.05, 0.42}), oak), back = addMesh(scene, makeBox({0.04, 0.95, 0.42}), oak);
  const int shortLeg = addMesh(scene, makeBox({0.05, 0.44, 0.05}), oak);
  addNode(scene, "seat", seat, {{0.52, 0.455, -0.75}});
  addNode(scene, "seat_back", back, {{0.75, 0.475, -0.75}});
  for (const double z : {-0.93, -0.57}) addNode(scene, "seat_leg", shortLeg, {{0.345, 0.22, z}});
}

}  // namespace

Scene makeRoomWithWindow() {
  Scene scene = namedScene("room_with_window");
  addShell(scene);
  addTable(scene);
  const int clay = addMaterial(scene, "clay", {0.80, 0.46, 0.34}), slate = addMaterial(scene, "slate", {0.46, 0.53, 0.60});
  const int bone = addMaterial(scene, "bone", {0.90, 0.87, 0.80}), sage = addMaterial(scene, "sage", {0.58, 0.64, 0.48});
  standNode(scene, "vase", addMesh(scene, makeCylinder(0.09, 0.28, 24), slate), -0.45, -1.05, turned(0.0, kUp), 0.75);
  standNode(scene, "bowl", addMesh(scene, makeTorus(0.15, 0.05, 24, 8), clay), -0.30, -0.55, turned(0.0, kUp), 0.75);
  standNode(scene, "cupboard", addMesh(scene, makeBox({0.45, 1.7, 1.0}), sage), 1.72, -1.85);
  standNode(scene, "chest", addMesh(scene, makeBox({1.1, 0.5, 0.5}), slate), -0.9, -2.2);
  const int sphere = addMesh(scene, makeIcosphere(0.19, 2), clay);
  standNode(scene, "ball_on_chest", sphere, -0.7, -2.2, turned(0.0, kUp), 0.5);
  const int ball = standNode(scene, "ball", sphere, 0.75, 0.25);
  const int pendant = addNode(scene, "pendant", -1, {{-0.35, kHeight, -0.75}});
  addChild(scene, pendant, addNode(scene, "shade", addMesh(scene, makeCone(0.28, 0.26, 24), bone), {{0.0, -0.85, 0.0}}));
  addChild(scene, pendant, addNode(scene, "cord", addMesh(scene, makeCylinder(0.012, 0.74, 8), slate), {{0.0, -0.37, 0.0}}));
  addNode(scene, "picture", addMesh(scene, makeBox({0.7, 0.5, 0.03}), slate), {{0.35, 1.6, -kHalfDepth + 0.03}});
  orbit(scene, ball, {0.55, 0.19, 0.25}, 0, 0.0);
  sway(scene, pendant, {1, 0, 0}, 12.0);
  addCamera(scene, {1.72, 1.62, 2.3}, {-0.45, 0.95, -1.0}, 58.0);
  scene.lighting.emplace();
  scene.lighting->exposure = 2.5f;  // what is left of the sky indoors
  return scene;
}

}  // namespace overcast
