// Visibility at rest: the fit to a surface against dense normal equations, the correction in closed forms, and whole frames of resting and
// moving objects.
#include "runtime/rest_visibility.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include <glm/geometric.hpp>

#include "formats/aperture.h"
#include "runtime/passes/shade/rest.h"
#include "runtime/rest_fit.h"
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

}  // namespace
}  // namespace overcast::test
