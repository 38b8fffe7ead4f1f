#include "tests/formats/random_scene.h"

#include <algorithm>
#include <numeric>
#include <random>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace overcast::test {
namespace {

struct Dice {
  std::mt19937_64 engine;

  double real(double low, double high) {  // not std::uniform_real_distribution: its numbers differ between libraries
    return low + (high - low) * (static_cast<double>(engine() >> 11) * 0x1p-53);
  }
  int integer(int low, int high) { return low + static_cast<int>(engine() % static_cast<std::uint64_t>(high - low + 1)); }
  bool chance(double p) { return real(0.0, 1.0) < p; }
  float single(double low, double high) { return static_cast<float>(real(low, high)); }
  glm::vec3 colour() { return {single(0, 5), single(0, 5), single(0, 5)}; }
  glm::dvec3 vector(double low, double high) { return {real(low, high), real(low, high), real(low, high)}; }
  glm::dvec3 floats(double low, double high) { return glm::dvec3(glm::vec3(vector(low, high))); }
  glm::vec3 direction() { return glm::vec3(glm::normalize(vector(-1, 1) + glm::dvec3(0, 2, 0))); }
  glm::dquat rotation() { return glm::normalize(glm::dquat(real(-1, 1), real(-1, 1), real(-1, 1), real(0.1, 1))); }
  double size() { return (chance(0.3) ? -1.0 : 1.0) * std::exp2(real(-3, 3)); }
  std::string name() {
    const char* names[] = {"", "box", "a \"quoted\" \\ name", "Gr\xC3\xBC\xC3\x9F", "\xE6\xA8\xA1\xE5\x9E\x8B", "line\nbreak", "a/b#c%20"};
    return names[integer(0, 6)];
  }
  Box box() {
    Box made;
    include(made, vector(-10, 10));
    include(made, vector(-10, 10));
    return made;
  }
};

std::string hash(Dice& dice) {
  std::string digits;
  for (int i = 0; i < 32; ++i) digits += "0123456789abcdef"[dice.integer(0, 15)];
  return digits;
}

VertexVisibility visibility(Dice& dice, std::size_t vertices) {
  VertexVisibility made;
  const bool apertures = dice.chance(0.8);
  if (apertures && dice.chance(0.5)) made.bits = ApertureBits::packed64;
  for (std::size_t i = 0; apertures && i < vertices; ++i) {
    made.apertures.push_back({dice.direction(), dice.single(0.0, 1.57)});
    made.ambient.push_back(dice.single(0.0, 1.0));
  }
  if (!apertures || dice.chance(0.5)) made.transfer.resize(vertices);
  for (std::array<float, 9>& transfer : made.transfer)
    for (float& t : transfer) t = dice.single(-1.0, 1.0);
  return asStored(std::move(made));
}

ApertureLink apertureLink(Dice& dice) {
  ApertureLink link{"maps/" + dice.name() + ".exr", hash(dice), dice.engine(), 0, dice.chance(0.5), -1.0, -1.0, -1.0};
  if (dice.chance(0.5)) return link;
  link.radiusError = dice.real(0.0, 1.0);
  link.ambientError = dice.real(0.0, 1.0);
  link.directionError = dice.real(0.0, 1.0);
  return link;
}

ApertureBake apertureBake(Dice& dice) {
  return {static_cast<std::uint32_t>(dice.integer(1, 4096)),
          dice.chance(0.5),
          dice.chance(0.5),
          dice.engine(),
          dice.engine(),
          dice.real(0.0, 1.0),
          dice.real(0.0, 1.0),
          dice.real(0.0, 1.0)};
}

Mesh mesh(Dice& dice, int materials) {
  Mesh made;
  made.name = dice.name();
  const int vertices = dice.integer(3, 12);
  for (int i = 0; i < vertices; ++i) {
    made.positions.push_back(dice.floats(-100, 100));
    made.normals.push_back(dice.direction());
  }
  if (dice.chance(0.5)) made.visibility = visibility(dice, made.positions.size());
  if (made.visibility && dice.chance(0.5)) made.apertureBake = apertureBake(dice);
  for (int parts = dice.integer(1, 3); parts > 0; --parts) {
    const int count = dice.integer(1, 5);
    made.parts.push_back(
        {static_cast<std::uint32_t>(made.triangles.size()), static_cast<std::uint32_t>(count), dice.integer(-1, materials - 1)});
    for (int i = 0; i < count; ++i)
      made.triangles.push_back({dice.integer(0, vertices - 1), dice.integer(0, vertices - 1), dice.integer(0, vertices - 1)});
  }
  if (dice.chance(0.5)) return made;
  for (int i = 0; i < vertices; ++i) made.textureCoordinates.emplace_back(dice.single(-2.0, 2.0), dice.single(-2.0, 2.0));
  if (dice.chance(0.5)) made.apertureMap = apertureLink(dice);
  return made;
}

void place(Dice& dice, Node& node) {
  const glm::dvec3 scale = dice.chance(0.1) ? glm::dvec3(0.0) : glm::dvec3(dice.size(), dice.size(), dice.size());
  if (dice.chance(0.3)) {
    const double size = std::abs(dice.size());
    const glm::dmat4 turned = glm::mat4_cast(dice.rotation());
    node.matrix = glm::scale(glm::translate(glm::dmat4(1.0), dice.vector(-9, 9)) * turned, glm::dvec3(dice.size(), size, 2.0));
  } else {
    node.translation = dice.vector(-1e4, 1e4);
    node.rotation = dice.rotation();
    node.scale = scale;
  }
}

void plantTrees(Dice& dice, std::vector<Node>& nodes) {
  std::vector<int> order(nodes.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), dice.engine);
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (dice.chance(0.3)) continue;
    const int parent = order[static_cast<std::size_t>(dice.integer(0, static_cast<int>(i) - 1))];
    nodes[static_cast<std::size_t>(order[i])].parent = parent;
    nodes[static_cast<std::size_t>(parent)].children.push_back(order[i]);
  }
}

AnimationChannel channel(Dice& dice, int node, AnimatedProperty property) {
  AnimationChannel made{node, property, static_cast<Interpolation>(dice.integer(0, 2)), {}, {}};
  const bool cubic = made.interpolation == Interpolation::cubicSpline;
  float time = dice.single(0, 1);
  for (int keys = dice.integer(cubic ? 2 : 1, 4); keys > 0; --keys, time += dice.single(0.1, 1)) {
    made.times.push_back(time);
    for (int k = 0; k < (cubic ? 3 : 1); ++k) {
      const glm::dquat q = dice.rotation();
      const glm::vec4 value =
          property == AnimatedProperty::rotation ? glm::vec4(glm::dvec4(q.x, q.y, q.z, q.w)) : glm::vec4(dice.floats(-3, 3), 0.0f);
      made.values.push_back(glm::dvec4(value));
    }
  }
  return made;
}

Occluder occluder(Dice& dice) {
  Occluder made;
  made.representation = static_cast<Representation>(dice.integer(0, 3));
  if (made.representation == Representation::primitive) {
    made.primitive = Primitive{dice.chance(0.5) ? PrimitiveShape::cuboid : PrimitiveShape::ellipsoid, dice.vector(-9, 9), dice.rotation(),
                               dice.vector(1e-3, 2)};
  } else {
    made.uri = dice.chance(0.5) ? "volumes/a b#%.vdb" : "mesh.vdb";
    made.contentHash = hash(dice);
  }
  made.bytes = dice.engine();
  if (made.representation == Representation::volume && dice.chance(0.7)) made.bits = 8 << dice.integer(0, 2);
  made.bounds = dice.box();
  made.influenceRadius = dice.real(0, 3);
  made.lipschitz = dice.real(0.5, 2);
  made.signMethod = "signed-crossings";
  made.inside = dice.chance(0.5) ? Inside::unstated : Inside::partly;
  made.sheetThickness = made.inside == Inside::partly ? 0.125 : 0.0;
  made.error.max = dice.real(0, 1);
  made.error.rms = dice.real(0, 1e-9);
  made.error.signErrors = dice.engine();
  made.error.samples = dice.engine();
  made.error.seed = dice.engine();
  if (dice.chance(0.7)) {
    made.error.p99 = dice.real(0, 1);
    made.error.surfaceRms = dice.real(0, 1e-9);
    made.error.skyRmse = dice.real(0, 1);
    made.error.method = "influence-1";
  }
  made.source = "bunny.obj";
  made.settingsHash = hash(dice);
  return made;
}

Lighting lighting(Dice& dice) {
  Lighting made;
  made.skyColour = dice.colour();
  made.up = dice.direction();
  if (dice.chance(0.5)) made.skyImage = "skies/dusk & dawn.exr";
  if (dice.chance(0.5)) made.sun = Sun{dice.direction(), dice.colour(), dice.single(1e-4, 1)};
  for (int i = dice.integer(0, 3); i > 0; --i)
    made.areaLights.push_back({glm::vec3(dice.vector(-9, 9)), dice.single(0.01, 2), dice.colour()});
  if (dice.chance(0.5)) made.globalVolume.bounds = dice.box();
  made.globalVolume.resolution = 8 * dice.integer(4, 32);
  Estimator& estimator = made.estimator;
  estimator.taps = dice.integer(1, 8);
  estimator.k = dice.single(0, 1);
  estimator.skyWeight = dice.single(0, 1);
  if (dice.chance(0.5)) estimator.fitError = dice.real(0, 1);
  if (dice.chance(0.5)) estimator.heldOutError = dice.real(0, 1);
  const auto weights = [&](int count) {
    std::vector<float> drawn(static_cast<std::size_t>(count));
    for (float& weight : drawn) weight = dice.single(0, 3);
    return drawn;
  };
  for (int i = dice.integer(0, static_cast<int>(kMostSkySteps)); i > 0; --i)
    estimator.steps.push_back(
        {weights(estimator.taps), weights(estimator.taps - 1), dice.single(-3, 3), dice.single(-1, 1), dice.single(0, 2)});
  if (dice.chance(0.5)) estimator.cones = SkyCones{dice.integer(1, 16), dice.single(0.01f, 2), dice.single(0, 1), dice.single(0.1f, 2)};
  made.exposure = dice.single(0.1, 4);
  return made;
}

}  // namespace

ApertureLink randomApertureLink(std::uint64_t seed) {
  Dice dice{std::mt19937_64(seed)};
  return apertureLink(dice);
}

ApertureBake randomApertureBake(std::uint64_t seed) {
  Dice dice{std::mt19937_64(seed)};
  return apertureBake(dice);
}

Occluder randomOccluder(std::uint64_t seed) {
  Dice dice{std::mt19937_64(seed)};
  return occluder(dice);
}

Lighting randomLighting(std::uint64_t seed) {
  Dice dice{std::mt19937_64(seed)};
  return lighting(dice);
}

Scene randomScene(std::uint64_t seed) {
  Dice dice{std::mt19937_64(seed)};
  Scene scene;
  scene.name = dice.name();
  for (int i = dice.integer(0, 3); i > 0; --i) scene.materials.push_back({dice.name(), {dice.single(0, 1), dice.single(0, 1), 0.5f, 1.0f}});
  for (int i = dice.integer(0, 2); i > 0; --i) scene.cameras.push_back({dice.name(), dice.real(0.1, 3), dice.real(1e-3, 1)});
  scene.nodes.resize(static_cast<std::size_t>(dice.integer(0, 8)));
  const int meshes = dice.integer(0, static_cast<int>(scene.nodes.size()));
  for (int i = 0; i < meshes; ++i) scene.meshes.push_back(mesh(dice, static_cast<int>(scene.materials.size())));
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    Node& node = scene.nodes[i];
    node.name = dice.name();
    place(dice, node);
    node.mesh = static_cast<int>(i) < meshes ? static_cast<int>(i) : dice.integer(-1, meshes - 1);
    node.camera = dice.integer(-1, static_cast<int>(scene.cameras.size()) - 1);
    if (dice.chance(0.4)) node.occluder = occluder(dice);
  }
  plantTrees(dice, scene.nodes);
  for (int i = dice.integer(0, 2); i > 0; --i) {
    Animation animation{dice.name(), {}};
    for (std::size_t n = 0; n < scene.nodes.size(); ++n)
      for (int property = 0; property < 3; ++property)
        if (!scene.nodes[n].matrix && dice.chance(0.2))
          animation.channels.push_back(channel(dice, static_cast<int>(n), static_cast<AnimatedProperty>(property)));
    if (!animation.channels.empty()) scene.animations.push_back(std::move(animation));
  }
  if (dice.chance(0.5)) scene.lighting = lighting(dice);
  return scene;
}

}  // namespace overcast::test
