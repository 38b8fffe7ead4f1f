#include "data/make/scenes.h"

#include <utility>

#include <glm/geometric.hpp>

#include "data/make/shapes.h"
#include "data/make/stage.h"

namespace overcast {
namespace {

// The room of Evans' figures: inside it x and z run over [-1, 1], y over [0, 2]. Walls reach into each other so that their union has no
// seam; each pair ends a centimetre apart where both are seen.
void addRoom(Scene& scene) {
  const double t = 0.15, inset = 0.01;
  const int white = addMaterial(scene, "white", {0.84, 0.79, 0.72});
  const int red = addMaterial(scene, "red", {0.78, 0.30, 0.24});
  const int green = addMaterial(scene, "green", {0.40, 0.60, 0.34});
  const int level = addMesh(scene, makeBox({2.0 + 2.0 * t, t, 2.0 + t}), white);
  addNode(scene, "floor", level, {{0.0, -0.5 * t, -0.5 * t}});
  addNode(scene, "ceiling", level, {{0.0, 2.0 + 0.5 * t, -0.5 * t}});
  const glm::dvec3 side(t - inset, 2.0 + t, 2.0 + t - 2.0 * inset);
  const double x = 1.0 + 0.5 * (t - inset), z = -0.5 * t;
  addNode(scene, "left", addMesh(scene, makeBox(side), red), {{-x, 1.0, z}});
  addNode(scene, "right", addMesh(scene, makeBox(side), green), {{x, 1.0, z}});
  const int back = addMesh(scene, makeBox({2.0 + t, 2.0 + t, t - 2.0 * inset}), white);
  addNode(scene, "back", back, {{0.0, 1.0, -1.0 - 0.5 * (t - 2.0 * inset)}});
  addCamera(scene, {0.0, 1.0, 4.4}, {0.0, 1.0, 0.0}, 38.0);
}

}  // namespace

Scene makeSphereOnPlane() {
  Scene scene = namedScene("sphere_on_plane");
  addGround(scene, 4.0, 4.0, addMaterial(scene, "plaster", {0.80, 0.74, 0.66}));
  const int sphere = addMesh(scene, makeIcosphere(0.5, 4), addMaterial(scene, "clay", {0.80, 0.52, 0.38}));
  addNode(scene, "sphere", sphere, {{0.0, 0.5, 0.0}});
  addCamera(scene, {0.0, 1.5, 3.6}, {0.0, 0.35, 0.0}, 36.0);
  return scene;
}

Scene makeCornellBox() {
  Scene scene = namedScene("cornell_box");
  addRoom(scene);
  const int cube = addMesh(scene, makeBox(glm::dvec3(0.7)), addMaterial(scene, "bone", {0.90, 0.86, 0.76}));
  const int node = standNode(scene, "cube", cube, 0.0, -0.05, turned(28.0, kUp));
  spin(scene, node, kUp, 90.0);
  return scene;
}

Scene makeCornellStar() {
  Scene scene = namedScene("cornell_star");
  addRoom(scene);
  const int star = addMesh(scene, makeStar(0.68, 5, 120, 48), addMaterial(scene, "bone", {0.90, 0.86, 0.76}));
  const int node = standNode(scene, "star", star, 0.0, -0.05, turned(90.0, {0, 0, 1}) * turned(90.0, {1, 0, 0}));
  sway(scene, node, kUp, 25.0);
  return scene;
}

Scene makeCornellKnot() {
  Scene scene = namedScene("cornell_knot");
  addRoom(scene);
  const int knot = addMesh(scene, makeTorusKnot(0.62, 0.15, 2, 3, 90, 10), addMaterial(scene, "bone", {0.90, 0.86, 0.76}));
  const int node = standNode(scene, "knot", knot, 0.0, -0.05, turned(12.0, kUp) * turned(-62.0, {1, 0, 0}));
  spin(scene, node, kUp, 360.0);
  return scene;
}

Scene makeClutter() {
  Scene scene = namedScene("clutter");
  addGround(scene, 4.4, 3.6, addMaterial(scene, "paper", {0.80, 0.74, 0.66}));
  const int clay = addMaterial(scene, "clay", {0.78, 0.45, 0.32}), sage = addMaterial(scene, "sage", {0.58, 0.64, 0.48});
  const int sand = addMaterial(scene, "sand", {0.86, 0.74, 0.52}), slate = addMaterial(scene, "slate", {0.46, 0.53, 0.60});
  const int bone = addMaterial(scene, "bone", {0.90, 0.87, 0.80});
  const int ball = addMesh(scene, makeIcosphere(0.32, 3), clay), smallBall = addMesh(scene, makeIcosphere(0.16, 3), sand);
  const int cube = addMesh(scene, makeBox(glm::dvec3(0.5)), slate), plank = addMesh(scene, makeBox({1.1, 0.12, 0.34}), sage);
  const int ring = addMesh(scene, makeTorus(0.32, 0.11, 48, 20), bone), smallRing = addMesh(scene, makeTorus(0.18, 0.06, 40, 16), clay);
  const int cone = addMesh(scene, makeCone(0.28, 0.7, 48), sage), smallCone = addMesh(scene, makeCone(0.18, 0.4, 40), sand);
  standNode(scene, "ball", ball, -1.15, -0.35);
  standNode(scene, "ball_far", ball, 1.25, -1.05);
  standNode(scene, "cube", cube, 0.05, -0.85, turned(24.0, kUp));
  const int top = standNode(scene, "cube_on_cube", cube, 0.08, -0.85, turned(60.0, kUp), 0.5);
  standNode(scene, "ring", ring, 0.15, 0.55);
  standNode(scene, "ball_in_ring", smallBall, 0.15, 0.55);
  standNode(scene, "cone", cone, -0.70, -1.15);
  standNode(scene, "cone_near", smallCone, -0.55, 0.95);
  standNode(scene, "plank", plank, 1.05, 0.05, turned(-32.0, kUp));
  standNode(scene, "ring_on_plank", smallRing, 1.05, 0.05, turned(0.0, kUp), 0.12);
  const int wheel = standNode(scene, "wheel", ring, -1.05, 0.55, turned(70.0, kUp) * turned(90.0, {1, 0, 0}));
  const int runner = standNode(scene, "runner", smallBall, 0.15, 1.25);
  const int tumbler = addNode(scene, "tumbler", smallRing, {{-0.42, 0.85, -0.20}, turned(35.0, {1, 0, 0})});
  const int hover = addNode(scene, "hover", smallCone, {{1.05, 0.55, 0.05}});
  spin(scene, top, kUp, 90.0);
  spin(scene, wheel, kUp, 180.0);
  spin(scene, tumbler, {0, 0, 1}, 360.0);
  sway(scene, hover, {1, 0, 0}, 25.0);
  orbit(scene, runner, {0.15, 0.16, 0.55}, 0, 0.0);
  addCamera(scene, {0.6, 2.5, 4.6}, {0.0, 0.35, -0.05}, 34.0);
  return scene;
}

namespace {

// Puts another closed shape beside those of a mesh, as a part of its own.
void addPart(Mesh& mesh, const Mesh& shape, const glm::dvec3& at) {
  const auto vertex = static_cast<std::uint32_t>(mesh.positions.size()), triangle = static_cast<std::uint32_t>(mesh.triangles.size());
  for (const glm::dvec3& position : shape.positions) mesh.positions.push_back(snapped(position + at));
  mesh.normals.insert(mesh.normals.end(), shape.normals.begin(), shape.normals.end());
  for (const glm::uvec3& t : shape.triangles) mesh.triangles.push_back(t + vertex);
  mesh.parts.push_back({triangle, static_cast<std::uint32_t>(shape.triangles.size()), -1});
}

// A lamp that moves with a node of its own, for orbit and sway.
int addLamp(Scene& scene, const std::string& name, const glm::dvec3& at, double radius, const glm::dvec3& radiance) {
  if (!scene.lighting) scene.lighting = Lighting{};
  const int node = addNode(scene, name, -1, {at});
  scene.lighting->areaLights.push_back({glm::vec3(0.0f), static_cast<float>(radius), glm::vec3(radiance), node});
  return node;
}

}  // namespace

Scene makeStatueTwoLights(Mesh statue) {
  Scene scene = namedScene("statue_two_lights");
  addGround(scene, 3.6, 3.6, addMaterial(scene, "paper", {0.78, 0.74, 0.68}));
  const int stone = addMaterial(scene, "stone", {0.86, 0.84, 0.80}), slate = addMaterial(scene, "slate", {0.52, 0.53, 0.56});
  standNode(scene, "plinth", addMesh(scene, makeCylinder(0.36, 0.16, 64), slate), 0.0, 0.0);
  standNode(scene, "statue", addMesh(scene, std::move(statue), stone), 0.0, 0.0, turned(25.0, kUp), 0.16);
  const int warm = addLamp(scene, "warm", {-0.85, 1.15, 0.95}, 0.14, {36.0, 19.0, 7.5});
  const int blue = addLamp(scene, "blue", {1.15, 0.80, 0.35}, 0.34, {1.3, 2.4, 6.2});
  orbit(scene, warm, {0.0, 1.15, 0.0}, 1, 0.3);
  orbit(scene, blue, {1.0, 0.80, -0.25}, 2, 0.6);
  scene.lighting->skyColour = {0.10f, 0.11f, 0.14f};
  addCamera(scene, {0.45, 2.35, 3.9}, {0.0, 0.56, 0.0}, 28.0);
  return scene;
}

Scene makeSphereOverPlane() {
  Scene scene = namedScene("sphere_over_plane");
  constexpr double kThickness = 0.25;
  Mesh both = makeSlab({4.0, kThickness, 4.0}, 0.08);
  addPart(both, makeIcosphere(0.5, 4), {0.0, 0.5 * kThickness + 0.85, 0.0});
  both.name = "sphere_over_plane";
  const int mesh = addMesh(scene, std::move(both), addMaterial(scene, "plaster", {0.80, 0.74, 0.66}));
  scene.meshes[static_cast<std::size_t>(mesh)].parts.back().material = addMaterial(scene, "clay", {0.80, 0.52, 0.38});
  addNode(scene, "sphere_over_plane", mesh, {{0.0, 0.5 * kThickness, 0.0}});
  const int lamp = addLamp(scene, "lamp", {1.1, 2.6, 0.6}, 0.25, {34.0, 31.0, 26.0});
  orbit(scene, lamp, {0.0, 2.6, 0.0}, 0, 0.0);
  scene.lighting->skyColour = {0.16f, 0.19f, 0.24f};
  addCamera(scene, {0.0, 2.1, 4.3}, {0.0, 0.6, 0.0}, 36.0);
  return scene;
}

namespace {

// A scanned mesh by name, or a shape of ours in its place.
Mesh scannedMesh(const std::filesystem::path& folder, const char* name, double longestSide, std::vector<std::string>& notes) {
  auto file = readMesh(folder / (std::string(name) + ".off"));
  Mesh mesh;
  if (file.ok()) {
    mesh = std::move(file).value().mesh;
  } else {
    notes.push_back(message(file.error()) + ": a torus knot takes its place");
    mesh = makeTorusKnot(0.5, 0.12, 2, 3, 240, 24);
  }
  fitToSize(mesh, longestSide);
  mesh.name = name;
  return mesh;
}

// The turn that brings `up` of a scanned mesh upright.
glm::dquat upright(const glm::dvec3& up) {
  const glm::dvec3 from = glm::normalize(up);
  const glm::dvec3 axis = glm::cross(from, kUp);
  return glm::normalize(glm::dquat(1.0 + glm::dot(from, kUp), axis.x, axis.y, axis.z));
}

}  // namespace

Scene makeDefault(const std::filesystem::path& folder, std::vector<std::string>& notes) {
  Scene scene = namedScene("default");
  addGround(scene, 4.6, 3.4, addMaterial(scene, "paper", {0.80, 0.74, 0.66}));
  const int grey = addMaterial(scene, "elephant", {0.64, 0.63, 0.64}), bone = addMaterial(scene, "bunny", {0.90, 0.86, 0.78});
  const int jade = addMaterial(scene, "armadillo", {0.58, 0.66, 0.52}), clay = addMaterial(scene, "clay", {0.80, 0.46, 0.34});
  const int sand = addMaterial(scene, "sand", {0.88, 0.74, 0.50}), slate = addMaterial(scene, "slate", {0.46, 0.53, 0.60});
  const int elephant = addMesh(scene, scannedMesh(folder, kScannedMeshes[0], 1.45, notes), grey);
  const int bunny = addMesh(scene, scannedMesh(folder, kScannedMeshes[1], 1.05, notes), bone);
  const int armadillo = addMesh(scene, scannedMesh(folder, kScannedMeshes[2], 1.35, notes), jade);
  // In its file the elephant leans over; this is the direction in which it rests on its feet.
  const glm::dquat elephantUpright = upright({-0.094, 0.854, 0.511});
  standNode(scene, "elephant", elephant, -1.15, -0.35, turned(35.0, kUp) * elephantUpright);
  const int turning = standNode(scene, "bunny", bunny, 0.05, 0.35, turned(15.0, kUp));
  standNode(scene, "armadillo", armadillo, 1.25, -0.45, turned(160.0, kUp));
  const int knot = addMesh(scene, makeTorusKnot(0.34, 0.075, 2, 3, 240, 20), clay);
  const int floating = addNode(scene, "knot", knot, {{0.10, 0.66, -1.05}});
  standNode(scene, "pedestal", addMesh(scene, makeCylinder(0.30, 0.22, 64), slate), 0.10, -1.05);
  standNode(scene, "ring", addMesh(scene, makeTorus(0.24, 0.085, 64, 24), sand), 1.25, 0.85);
  standNode(scene, "cube", addMesh(scene, makeBox(glm::dvec3(0.36)), slate), -0.95, 0.95, turned(30.0, kUp));
  const int ball = standNode(scene, "ball", addMesh(scene, makeIcosphere(0.12, 4), clay), 0.05, 1.20);
  sway(scene, turning, kUp, 18.0);
  spin(scene, floating, kUp, 360.0);
  orbit(scene, ball, {0.05, 0.12, 0.35}, 3, 0.18);
  addCamera(scene, {0.45, 2.75, 5.1}, {0.03, 0.40, -0.02}, 31.0);
  return scene;
}

}  // namespace overcast
