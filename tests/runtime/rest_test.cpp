// Visibility at rest: the fit to a surface against dense normal equations, the correction in closed forms, and whole frames of resting and
// moving objects.
#include "runtime/rest_visibility.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <tuple>

#include <glm/geometric.hpp>

#include "formats/aperture.h"
#include "formats/aperture_map.h"
#include "runtime/passes/shade/rest.h"
#include "runtime/passes/shade/sky_points_pass.h"
#include "runtime/rest_fit.h"
#include "runtime/rest_window.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/frames.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;

TEST(RestFormulas, NothingChangesWhereTheEstimatorSaysTheSame) {
  for (const float baked : {0.0f, 0.2f, 0.7f, 1.0f})
    for (const float rest : {0.0f, 0.1f, 0.6f, 1.0f}) {
      EXPECT_NEAR(shared::correctedVisibility(baked, rest, rest, 1.0f), baked, 1e-6f);
      EXPECT_EQ(shared::shareLeft(rest, rest), 1.0f);
      EXPECT_EQ(shared::correctedVisibility(baked, 1.0f, 1.0f, shared::kTrustBeyond), baked);
    }
}

TEST(RestFormulas, TrustSaysWhetherOthersAreKnown) {
  for (const float share : {0.0f, 0.3f, 1.0f}) {
    EXPECT_FALSE(shared::restKnowsOthers(share));
    EXPECT_TRUE(shared::restKnowsOthers(shared::knowingTrust(share)));
    EXPECT_FALSE(shared::restIsLookedUp(shared::knowingTrust(share)));
    EXPECT_NEAR(shared::correctedVisibility(0.6f, 0.8f, 0.4f, shared::knowingTrust(share)),
                shared::correctedVisibility(0.6f, 0.8f, 0.4f, share), 1e-6f);
  }
  EXPECT_TRUE(shared::restKnowsOthers(shared::kTrustBeyond) && shared::restKnowsOthers(2.0f * shared::kTrustBeyond));
}

TEST(RestFormulas, StayWithinWhatCanBeAndGrowWithTheEstimator) {
  for (float baked = 0.0f; baked <= 1.0f; baked += 0.125f)
    for (float rest = 0.0f; rest <= 1.0f; rest += 0.125f)
      for (const float trust : {0.0f, 0.4f, 1.0f}) {
        float before = -1.0f;
        for (float now = 0.0f; now <= 1.0f; now += 0.03125f) {
          const float visible = shared::correctedVisibility(baked, rest, now, trust);
          EXPECT_GE(visible, before - 1e-6f);
          EXPECT_LE(visible, 1.0f + 1e-6f);
          EXPECT_GE(visible, 0.0f);
          before = visible;
        }
      }
  EXPECT_FLOAT_EQ(shared::correctedVisibility(0.3f, 0.5f, 0.8f, 0.0f), 0.8f) << "without trust the estimator is all there is";
  EXPECT_NEAR(shared::correctedVisibility(0.6f, 0.8f, 0.4f, 1.0f), 0.3f, 0.01f) << "half of it is left";
  EXPECT_NEAR(shared::correctedVisibility(0.6f, 0.5f, 1.0f, 1.0f), 1.0f, 0.02f) << "all is open again";
}

TEST(RestFit, LeavesFineMeshesAndFollowsWhatIsLinear) {
  const std::vector<glm::vec3> positions{{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}};
  const std::vector<glm::uvec3> triangles{{0, 1, 2}, {0, 2, 3}};
  EXPECT_TRUE(spotsOver(positions, triangles, 12.0f).empty());
  const std::vector<SurfaceSpot> spots = spotsOver(positions, triangles, 2.0f);
  float area = 0.0f;
  std::vector<float> seen;
  for (const SurfaceSpot& spot : spots) {
    area += spot.area;
    glm::vec3 p(0.0f);
    for (int c = 0; c < 3; ++c) p += spot.weight[c] * positions[spot.corner[c]];
    seen.push_back(0.2f + 0.05f * p.x + 0.03f * p.y);
  }
  EXPECT_NEAR(area, 2.0f * 64.0f, 1e-3f) << "twice the area of the square";
  const std::vector<float> start{0.2f, 0.6f, 0.84f, 0.44f};
  const std::vector<float> fitted = fittedTo(start, spots, seen);
  for (int v = 0; v < 4; ++v) EXPECT_NEAR(fitted[v], start[v], 1e-4f);
  EXPECT_EQ(fittedTo(start, {}, {}), start);
}

/// x of A x = b by elimination.
std::vector<double> solved(std::vector<std::vector<double>> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(a[i][k]) > std::abs(a[k][k])) {
        std::swap(a[i], a[k]);
        std::swap(b[i], b[k]);
      }
    for (std::size_t i = k + 1; i < n; ++i) {
      const double f = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= f * a[k][j];
      b[i] -= f * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

TEST(RestFit, IsTheLeastSquares) {
  const Mesh mesh = reference::icosphere(6.0, 1);
  std::vector<glm::vec3> positions(mesh.positions.begin(), mesh.positions.end());
  const std::vector<SurfaceSpot> spots = spotsOver(positions, mesh.triangles, 1.0f);
  std::mt19937 random(5);
  std::vector<float> start(positions.size(), 0.5f), seen;
  for (std::size_t i = 0; i < spots.size(); ++i) seen.push_back(0.5f + 0.4f * (static_cast<float>(random() % 1000) / 1000.0f - 0.5f));
  const std::size_t n = start.size();
  std::vector<std::vector<double>> a(n, std::vector<double>(n, 0.0));
  std::vector<double> b(n, 0.0);
  for (std::size_t s = 0; s < spots.size(); ++s)
    for (int i = 0; i < 3; ++i) {
      const double share = double{spots[s].area} * spots[s].weight[i];
      b[spots[s].corner[i]] += share * (seen[s] + 0.01 * 0.5);
      a[spots[s].corner[i]][spots[s].corner[i]] += 0.01 * share;
      for (int j = 0; j < 3; ++j) a[spots[s].corner[i]][spots[s].corner[j]] += share * spots[s].weight[j];
    }
  const std::vector<double> expected = solved(std::move(a), std::move(b));
  const std::vector<float> fitted = fittedTo(start, spots, seen);
  for (std::size_t v = 0; v < n; ++v) EXPECT_NEAR(fitted[v], expected[v], 1e-4) << v;
}

/// Gives every vertex the same aperture, and a record of how it was baked.
void giveApertures(Mesh& mesh, float ambient, bool sceneOccludes) {
  const std::size_t vertices = mesh.positions.size();
  if (mesh.normals.empty())
    for (const glm::dvec3& p : mesh.positions) mesh.normals.emplace_back(glm::normalize(p));
  std::vector<Aperture> apertures;
  for (const glm::vec3& normal : mesh.normals) apertures.push_back({normal, shared::kApertureWidest});
  mesh.visibility = VertexVisibility{ApertureBits::packed64, std::move(apertures), std::vector<float>(vertices, ambient), {}};
  mesh.apertureBake.emplace();
  mesh.apertureBake->sceneOccludes = sceneOccludes;
}

class Rest : public Frames {
 protected:
  /// bakedScene's floor, which was baked with all that rests and says `ambient` everywhere; its ball, open, at `ball`, which an animation
  /// takes 3 m up within a second; and where `boxes`, the two boxes on the floor.
  Scene make(const glm::dvec3& ball, float ambient, bool boxes) {
    Scene made = bakedScene(temporaryFolder(), {.animated = false, .camera = false, .resolution = 64});
    if (!boxes) made.nodes.resize(2);
    made.meshes[0].normals.assign(made.meshes[0].positions.size(), {0, 1, 0});
    giveApertures(made.meshes[0], ambient, true);
    giveApertures(made.meshes[1], 1.0f, true);
    giveApertures(made.meshes[2], 1.0f, true);
    made.nodes[1].translation = ball;
    AnimationChannel channel;
    channel.node = 1;
    channel.times = {0.0, 1.0};
    channel.values = {glm::dvec4(ball, 0.0), glm::dvec4(ball + glm::dvec3(0.0, 3.0, 0.0), 0.0)};
    made.animations.push_back({"leave", {channel}});
    return made;
  }
  void openScene(const Scene& made, const std::string& estimator) {
    const fs::path file = temporaryFolder() / "rest.gltf";
    const auto written = writeScene(file, made);
    ASSERT_TRUE(written.ok()) << message(written.error());
    FrameSettings wanted{160, 120, 1, {}, {}};
    wanted.estimator = estimator;
    Frames::open(file, wanted);
  }
  /// Sky visibility at points of the floor.
  float skyAt(const glm::dvec3& point, double time) {
    const View view = lookAt({0.0, 5.0, 4.0}, {0.0, 0.0, 0.0}, {0, 1, 0}, 0.6);
    EXPECT_TRUE(renderFrame(device, renderer, scene, time, view).ok());
    const Image image = linear();
    const glm::ivec2 pixel = pixelOf(renderer, view, point);
    return at(image, pixel.x, pixel.y, channelIndex(image, "sky"));
  }
};

/// What a sphere of radius 0.5 above the horizon of a floor point takes of its sky (the form factor).
double takenByBall(const glm::dvec3& ball, const glm::dvec3& point) {
  const glm::dvec3 way = ball - point;
  return 0.25 * way.y / std::pow(glm::length(way), 3.0);
}

TEST_F(Rest, HoveringBallTakesWhatItHides) {
  const glm::dvec3 ball(0.0, 0.8, 0.0);
  const Scene made = make(ball, 0.8f, false);
  // Four taps are no more than a guess at how much sky a ball takes.
  for (const auto& [estimator, tolerance, share] : {std::tuple{"hybrid", 0.04, 0.4}, std::tuple{"hybrid-traced", 0.02, 0.15}}) {
    openScene(made, estimator);
    const View view = lookAt({0.0, 5.0, 4.0}, {0.0, 0.0, 0.0}, {0, 1, 0}, 0.6);
    ASSERT_TRUE(renderFrame(device, renderer, scene, 0.0, view).ok());
    const Image image = linear();
    double squares = 0.0, taken = 0.0, truth = 0.0;
    int count = 0;
    for (double x = -1.6; x < 1.6; x += 0.1, ++count) {
      const glm::dvec3 point(x, 0.0, 0.55);
      const glm::ivec2 pixel = pixelOf(renderer, view, point);
      const double sky = double{at(image, pixel.x, pixel.y, channelIndex(image, "sky"))};
      squares += std::pow(sky - 0.8 * (1.0 - takenByBall(ball, point)), 2.0);
      taken += 0.8 - sky;
      truth += 0.8 * takenByBall(ball, point);
    }
    RecordProperty(estimator, fmt::format("RMS {:.4f}, taken {:.3f} of the truth", std::sqrt(squares / count), taken / truth));
    EXPECT_LT(std::sqrt(squares / count), tolerance) << estimator;
    EXPECT_NEAR(taken / truth, 1.0, share) << estimator << " takes in all";
    close();
  }
}

TEST_F(Rest, ObjectsThatLeaveGiveTheLightBack) {
  openScene(make({0.0, 0.6, 0.0}, 0.7f, false), "hybrid-traced");
  const glm::dvec3 point(0.5, 0.0, 0.3);
  EXPECT_LT(skyAt(point, 0.0), 0.6f);
  EXPECT_NEAR(skyAt(point, 1.0 - 1e-9), 0.7f, 0.03f);
}

TEST_F(Rest, NeighboursOfTheBakeAreNotTakenTwice) {
  // Beside a box, which the floor's apertures know of: their word is the last, whatever the estimator says of the box.
  Scene made = make({80.0, 4.0, 0.0}, 0.4f, true);
  made.lighting->globalVolume.bounds = Box{{-2.0, -0.5, -2.0}, {2.0, 1.5, 2.0}};
  for (const char* estimator : {"hybrid", "hybrid-traced"}) {
    openScene(made, estimator);
    EXPECT_TRUE(renderer.rest && renderer.rest->volume);
    for (const double x : {0.0, 0.15, 0.2}) EXPECT_NEAR(skyAt({x, 0.0, -0.3}, 0.0), 0.4f, 1e-3f) << estimator << " at " << x;
    close();
  }
}

/// What the map of giveMap says at x.
float mapped(double x) {
  return static_cast<float>(0.6 + 0.2 * std::sin(2.0 * x));
}

/// The floor's apertures as a map in place of vertices: an open cap everywhere, ambient visibility as in mapped(), and word that it errs by
/// `error` between texels.
void giveMap(Mesh& floor, const fs::path& folder, double error) {
  constexpr int kSide = 64;
  ApertureMap map{{kSide, kSide}, {std::vector<ApertureTexel>(kSide * kSide)}, 1};
  for (int i = 0; i < kSide * kSide; ++i)
    map.levels[0][static_cast<std::size_t>(i)] = {
        {{0, 1, 0}, shared::kApertureWidest}, mapped((i % kSide + 0.5) * 4.0 / kSide - 2.0), 1.0f};
  buildLevels(map);
  ApertureLink link;
  link.uri = "floor.exr";
  link.bytes = writeApertureMap(folder / link.uri, map).value();
  link.contentHash = contentHash(readFile(folder / link.uri).value());
  link.sceneOccludes = true;
  link.radiusError = link.directionError = 0.0;
  link.ambientError = error;
  floor.visibility.reset();
  floor.apertureBake.reset();
  for (const glm::dvec3& p : floor.positions) floor.textureCoordinates.emplace_back((p.x + 2.0) / 4.0, (p.z + 2.0) / 4.0);
  floor.apertureMap = link;
}

TEST_F(Rest, MapsLoseWhatTheBallTakesAndNothingElse) {
  const glm::dvec3 ball(0.0, 0.8, 0.0);
  Scene made = make(ball, 1.0f, false);
  giveMap(made.meshes[0], temporaryFolder(), 0.005);
  openScene(made, "hybrid-traced");
  EXPECT_TRUE(renderer.rest && renderer.rest->volume) << "texels are fine: what rests is looked up as finely";
  double squares = 0.0;
  int count = 0;
  for (double x = -1.6; x < 1.65; x += 0.2, ++count) {
    const glm::dvec3 point(x, 0.0, 0.55);
    squares += std::pow(static_cast<double>(skyAt(point, 0.0)) - mapped(x) * (1.0 - takenByBall(ball, point)), 2.0);
  }
  EXPECT_LT(std::sqrt(squares / count), 0.03);
  for (const glm::dvec3 point : {glm::dvec3(-0.8, 0.0, 0.9), {0.0, 0.0, 0.55}, {0.8, 0.0, 0.3}})
    EXPECT_NEAR(skyAt(point, 1.0 - 1e-9), mapped(point.x) * (1.0 - takenByBall({0.0, 3.8, 0.0}, point)), 0.012) << "3 m up";
}

TEST_F(Rest, MapsThatKnowTheirNeighboursKeepTheirWord) {
  // As NeighboursOfTheBakeAreNotTakenTwice; then nothing moves, then the map says of itself that it misses contact shadows.
  Scene made = make({80.0, 4.0, 0.0}, 1.0f, true);
  giveMap(made.meshes[0], temporaryFolder(), 0.005);
  made.lighting->globalVolume.bounds = Box{{-2.0, -0.5, -2.0}, {2.0, 1.5, 2.0}};
  for (const char* estimator : {"hybrid", "hybrid-traced"}) {
    openScene(made, estimator);
    for (const double x : {0.0, 0.15, 0.2}) EXPECT_NEAR(skyAt({x, 0.0, -0.3}, 0.0), mapped(x), 0.012) << estimator << " at " << x;
    close();
  }
  made.animations.clear();
  openScene(made, "hybrid-traced");
  EXPECT_FALSE(canChange(scene));
  EXPECT_FALSE(renderer.rest);
  EXPECT_NEAR(skyAt({0.15, 0.0, -0.3}, 0.0), mapped(0.15), 0.012);
  close();
  made.meshes[0].apertureMap->ambientError = 0.3;
  openScene(made, "hybrid-traced");
  ASSERT_TRUE(renderer.rest);
  EXPECT_FALSE(renderer.rest->volume);
  EXPECT_LT(skyAt({0.2, 0.0, -0.3}, 0.0), mapped(0.2) - 0.1f) << "the estimator sees the box that the map hardly knows of";
  EXPECT_NEAR(skyAt({-1.5, 0.0, 1.5}, 0.0), 1.0f, 0.05f) << "and nothing far from it";
}

TEST_F(Rest, WhatCannotChangeIsNotLookedAt) {
  Scene made = make({-0.7, 0.5, 0.0}, 0.4f, true);
  made.animations.clear();
  openScene(made, "hybrid");
  EXPECT_FALSE(canChange(scene));
  EXPECT_FALSE(renderer.rest);
  EXPECT_NEAR(skyAt({0.0, 0.0, -0.3}, 0.0), 0.4f, 1e-3f);
  EXPECT_NEAR(skyAt({-0.7, 0.0, 0.55}, 0.0), 0.4f, 1e-3f);
  close();
  made.meshes[0].apertureBake->samples = 100;
  made.meshes[0].apertureBake->ambientError = 0.2;
  openScene(made, "hybrid");
  EXPECT_TRUE(canChange(scene)) << "apertures that say of themselves that they miss contact shadows";
  EXPECT_FALSE(renderer.rest->volume);
  close();
  made.meshes[0].apertureBake.reset();
  openScene(made, "hybrid");
  EXPECT_TRUE(canChange(scene)) << "apertures of the floor alone know of no box";
}

TEST_F(Rest, AloneObjectsKnowOfThemselves) {
  // A box on the floor, both baked alone: far from each other nothing but what was baked is seen.
  Scene made = make({-1.6, 4.0, -1.6}, 0.4f, true);
  for (Mesh& mesh : made.meshes) mesh.apertureBake->sceneOccludes = false;
  openScene(made, "hybrid-traced");
  EXPECT_FALSE(renderer.rest->volume);
  EXPECT_NEAR(skyAt({-1.2, 0.0, 1.2}, 0.0), 0.4f, 0.03f);
  EXPECT_LT(skyAt({0.1, 0.0, -0.3}, 0.0), 0.33f) << "the box stands there";
}

/// Where in memory each object's values begin, less its mesh's first vertex.
std::vector<shared::RestInstance> restInstances(const Device& device, const RestVisibility& rest) {
  return readValues<shared::RestInstance>(device, rest.buffers.instances).value();
}

/// What the estimator says at the vertices of `object` alone in the whole of `grid`.
std::vector<SkySeen> seenInWhole(const Device& device, const RuntimeScene& scene, const AssetStore& store, const GlobalGrid& grid,
                                 const SkyEstimator& estimator, const SceneObject& object) {
  CompositePass composite = makeCompositePass(device, grid, store, 1).value();
  PyramidPass pyramid = makePyramidPass(device, composite.volume, estimator.levels).value();
  SkyPointsPass pass = makeSkyPointsPass(device, pyramid, estimator).value();
  const glm::dmat4 world = worldFromLocal(scene.scene, 0.0)[object.node], voxel = voxelFromWorld(grid) * world;
  const std::array alone{compositeObject(store.entries[object.asset], world, grid)};
  const auto done = runCommands(device, [&](VkCommandBuffer commands) {
    if (recordComposite(commands, composite, alone)) recordPyramid(commands, pyramid);
  });
  EXPECT_TRUE(done.ok());
  const SceneMesh& mesh = scene.meshes[object.mesh];
  const std::vector<float> vertices = readValues<float>(device, scene.vertices).value();
  const glm::dmat3 turned = glm::transpose(glm::inverse(glm::dmat3(world)));
  std::vector<shared::SkyPoint> points;
  for (std::uint32_t v = 0; v < mesh.vertexCount; ++v) {
    const float* at = &vertices[(static_cast<std::size_t>(mesh.parts.front().vertexOffset) + v) * shared::kVertexFloats];
    const glm::dvec3 place = voxel * glm::dvec4(mesh.centre + glm::dvec3(at[0], at[1], at[2]), 1.0);
    points.push_back({glm::vec4(place, 1.0f), glm::vec4(glm::normalize(turned * glm::dvec3(at[3], at[4], at[5])), 0.0f)});
  }
  std::vector<SkySeen> seen = seenAt(device, pass, points, scene.lighting.up).value();
  destroySkyPointsPass(device, pass);
  destroyPyramidPass(device, pyramid);
  destroyCompositePass(device, composite);
  return seen;
}

/// A bowl, which sees itself, of four spheres' worth of vertices: finer than the voxels.
void makeBowl(Scene& made, const fs::path& folder) {
  const auto bowl = [](const glm::dvec3& p) { return std::max(std::abs(glm::length(p) - 0.42) - 0.08, p.y - 0.1); };
  made.nodes[1].occluder = writeOccluder(folder, "bowl", sampledVolume({glm::dvec3(-0.5), {0.5, 0.1, 0.5}}, 48, bowl));
  Mesh& mesh = made.meshes[1] = reference::icosphere(0.34, 4);
  for (glm::dvec3& p : mesh.positions) {
    mesh.normals.emplace_back(-glm::normalize(p));
    p.y = std::min(p.y, 0.1);
  }
  mesh.parts = {{0, static_cast<std::uint32_t>(mesh.triangles.size()), 1}};
}

TEST_F(Rest, AnObjectAloneSeesInItsSurroundingsWhatItSeesInTheWholeVolume) {
  Scene made = make({-0.7, 0.5, 0.0}, 1.0f, false);
  makeBowl(made, temporaryFolder());
  const Node bowl = made.nodes[1];
  made.nodes[0].scale = {1.3, 1.0, 1.0};
  made.animations.clear();
  for (const glm::dvec3& at : {glm::dvec3(1.2, 0.9, 0.7), {1.93, 0.2, -1.97}}) {  // one sticks out of the volume
    made.nodes.push_back(bowl);
    made.nodes.back().translation = at;
    made.nodes.back().scale = glm::dvec3(at.x > 1.5 ? 0.4 : 0.7);
  }
  for (Mesh& mesh : made.meshes) giveApertures(mesh, 1.0f, false);
  made.lighting->globalVolume = {Box{{-2.0, -0.3, -2.0}, {2.0, 2.0, 2.0}}, 96};
  openScene(made, "hybrid-traced");
  ASSERT_TRUE(renderer.rest);
  const std::vector<float> values = readValues<float>(device, renderer.rest->buffers.values).value();
  const auto places = restInstances(device, *renderer.rest);
  for (std::size_t i = 1; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const shared::CompositeObject record =
        compositeObject(renderer.store.entries[object.asset], worldFromLocal(scene.scene, 0.0)[object.node], renderer.grid);
    EXPECT_LT(windowAbout(renderer.grid, record).size.x, renderer.grid.size.x) << "else nothing is tested";
    const auto seen = seenInWhole(device, scene, renderer.store, renderer.grid, renderer.estimator, object);
    double least = 1.0, worst = 0.0;
    const int first = places[i].shift + scene.meshes[object.mesh].parts.front().vertexOffset;
    for (std::size_t v = 0; v < seen.size(); ++v) {
      least = std::min(least, static_cast<double>(seen[v].visibility));
      worst = std::max(worst, std::abs(static_cast<double>(values[static_cast<std::size_t>(first) + v]) - seen[v].visibility));
    }
    EXPECT_LT(least, 0.7) << "object " << i << " hides nothing of itself";
    EXPECT_LT(worst, 1.5 / 128.0) << "object " << i << ": more than the rounding of a ray of 128";
  }
}

TEST_F(Rest, TurnedInstancesShareWhatRaysSeeOfThem) {
  Scene made = make({-0.7, 0.8, 0.0}, 1.0f, false);
  makeBowl(made, temporaryFolder());
  made.nodes.push_back(made.nodes[1]);
  made.nodes.back().translation = {0.9, 0.8, 0.3};
  made.nodes.back().rotation = glm::angleAxis(2.2, glm::normalize(glm::dvec3(1.0, 0.3, -0.6)));
  for (Mesh& mesh : made.meshes) giveApertures(mesh, 1.0f, false);
  const auto apart = [&] {
    const auto& objects = scene.objects;
    const auto own = seenInWhole(device, scene, renderer.store, renderer.grid, renderer.estimator, objects[1]);
    const auto turned = seenInWhole(device, scene, renderer.store, renderer.grid, renderer.estimator, objects[2]);
    double squares = 0.0;
    for (std::size_t v = 0; v < own.size(); ++v) squares += std::pow(own[v].visibility - turned[v].visibility, 2.0);
    return std::sqrt(squares / static_cast<double>(own.size()));
  };
  openScene(made, "hybrid-traced");
  const auto traced = restInstances(device, *renderer.rest);
  EXPECT_EQ(traced[1].shift, traced[2].shift);
  EXPECT_LT(apart(), 0.03) << "what voxels do to it";
  close();
  openScene(made, "hybrid");
  const auto tapped = restInstances(device, *renderer.rest);
  EXPECT_NE(tapped[1].shift, tapped[2].shift);
  EXPECT_GT(apart(), 0.05) << "taps reach to the border of the volume, which is not as far from both";
}

TEST(RestWindow, HoldsTheBoxAndLiesInTheGrid) {
  const GlobalGrid grid = globalGrid(Box{glm::dvec3(-2.0), {2.0, 0.5, 2.0}}, 128);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-2.4, 2.4), size(0.02, 1.0);
  for (int run = 0; run < 300; ++run) {
    const glm::dvec3 half(size(random), size(random), size(random));
    const double angle = place(random);
    glm::dmat4 world = glm::mat4_cast(glm::angleAxis(angle, glm::normalize(glm::dvec3(1.0, angle, 0.3))));
    world[3] = glm::dvec4(place(random), place(random), place(random), 1.0);
    const shared::CompositeObject object = compositeObject(Primitive{PrimitiveShape::cuboid, {}, {1, 0, 0, 0}, half}, world, grid);
    const GlobalGrid window = windowAbout(grid, object);
    const glm::dvec3 first = (window.origin - grid.origin) / grid.voxelSize, last = first + glm::dvec3(window.size);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(first[axis], std::round(first[axis]), 1e-9);
      EXPECT_GE(first[axis], -1e-9);
      EXPECT_LE(last[axis], grid.size[axis] + 1e-9);
      EXPECT_EQ(window.size[axis] % shared::kBrickSide, 0);
    }
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 local(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y, corner & 4 ? half.z : -half.z);
      const glm::dvec3 at =
          glm::clamp(glm::dvec3(voxelFromWorld(grid) * world * glm::dvec4(local, 1.0)), glm::dvec3(0.0), glm::dvec3(grid.size));
      EXPECT_TRUE(glm::all(glm::greaterThanEqual(at, first - 1e-6)) && glm::all(glm::lessThanEqual(at, last + 1e-6))) << run;
    }
  }
}

}  // namespace
}  // namespace overcast::test
