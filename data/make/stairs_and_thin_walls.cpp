#include "data/make/scenes.h"
#include "data/make/shapes.h"
#include "data/make/stage.h"

namespace overcast {

Scene makeStairsAndThinWalls() {
  constexpr double kThin = 0.03, kRun = 0.22, kRise = 0.16, kWidth = 1.0;
  constexpr int kSteps = 6;
  Scene scene = namedScene("stairs_and_thin_walls");
  addGround(scene, 4.6, 3.6, addMaterial(scene, "concrete", {0.76, 0.74, 0.70}));
  const int bone = addMaterial(scene, "bone", {0.90, 0.87, 0.80}), clay = addMaterial(scene, "clay", {0.78, 0.45, 0.32});
  const int slate = addMaterial(scene, "slate", {0.46, 0.53, 0.60}), sand = addMaterial(scene, "sand", {0.86, 0.74, 0.52});
  const double length = kSteps * kRun, height = kSteps * kRise;
  addNode(scene, "stairs", addMesh(scene, makeStairs(kSteps, kRun, kRise, kWidth), bone), {{-0.55, 0.5 * height, -0.9}});
  const double landing = -0.55 + 0.5 * length + 0.44;
  addNode(scene, "landing", addMesh(scene, makeBox({0.90, 0.08, kWidth}), bone), {{landing, height - 0.04, -0.9}});
  addNode(scene, "pier", addMesh(scene, makeBox({0.08, height - 0.07, kWidth}), bone), {{landing + 0.40, 0.5 * (height - 0.07), -0.9}});
  const int post = addMesh(scene, makeCylinder(0.02, 0.5, 12), slate);
  for (int i = 0; i < kSteps; ++i)
    standNode(scene, "post", post, -0.55 - 0.5 * length + kRun * (i + 0.5), -0.44, turned(0.0, kUp), kRise * (i + 1));
  addNode(scene, "wall", addMesh(scene, makeBox({2.6, 1.7, kThin}), sand), {{-0.2, 0.85, -1.5}});
  addNode(scene, "screen", addMesh(scene, makeBox({kThin, 1.1, 1.4}), clay), {{-1.75, 0.55, -0.3}});
  const int fin = addMesh(scene, makeBox({kThin, 0.9, 0.34}), slate);
  for (int i = 0; i < 6; ++i) standNode(scene, "fin", fin, 0.55 + 0.24 * i, 0.55, turned(25.0, kUp));
  const int shelf = addMesh(scene, makeBox({0.9, kThin, 0.4}), clay), side = addMesh(scene, makeBox({kThin, 0.7, 0.4}), clay);
  for (const double y : {0.22, 0.46, 0.685}) addNode(scene, "shelf", shelf, {{-0.75, y, 0.75}});
  for (const double x : {-1.19, -0.31}) standNode(scene, "shelf_side", side, x, 0.75);
  const int door = standNode(scene, "door", addMesh(scene, makeBox({0.55, 1.0, kThin}), sand), 0.10, 0.25, turned(35.0, kUp));
  const int ball = standNode(scene, "ball", addMesh(scene, makeIcosphere(0.14, 2), clay), 0.35, 1.25);
  sway(scene, door, kUp, 40.0);
  orbit(scene, ball, {-0.15, 0.14, 1.25}, 3, 0.25);
  addCamera(scene, {-1.6, 2.5, 4.5}, {-0.02, 0.45, -0.2}, 34.0);
  return scene;
}

}  // namespace overcast
