#include "runtime/frame.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "tests/runtime/baked_scene.h"
#include "tests/runtime/frames.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;

TEST_F(Frames, AreTheSameBytesWhateverCameBefore) {
  const fs::path file = writeBakedScene(temporaryFolder(), {.animated = true});
  open(file, settings);
  std::vector<Image> forward;
  for (int frame = 0; frame < 5; ++frame) {
    render(0.15 * frame);
    forward.push_back(linear());
  }
  for (int frame = 4; frame >= 0; --frame) {
    render(0.15 * frame);
    EXPECT_EQ(linear().pixels, forward[static_cast<std::size_t>(frame)].pixels) << "frame " << frame << ", backwards";
  }
  EXPECT_NE(forward[0].pixels, forward[4].pixels) << "the sphere moves";
  const Image shown = display();
  close();
  open(file, settings);
  render(0.0);
  EXPECT_EQ(linear().pixels, forward[0].pixels) << "a fresh renderer";
  EXPECT_EQ(display().pixels, shown.pixels);
}

TEST_F(Frames, SkipCompositeAndPyramidWhileNothingMoves) {
  const auto skipped = [](const std::vector<PassTime>& times) {
    std::vector<bool> list;
    for (const PassTime& time : times) list.push_back(time.skipped);
    return list;
  };
  open(writeBakedScene(temporaryFolder(), {.animated = true}), settings);
  const std::vector<bool> all(6, false), still{true, true, false, false, false, false};  // geometry, shade, denoise and tonemap run
  EXPECT_EQ(skipped(render(0.0)), all);
  EXPECT_EQ(skipped(render(0.0)), still);
  EXPECT_EQ(skipped(render(0.2)), all);
  EXPECT_EQ(skipped(render(2.2)), still) << "the animation loops: the same pose again";
}

TEST_F(Frames, MakeTheSameOfABorrowedVolume) {
  open(writeBakedScene(temporaryFolder(), {.animated = true}), settings);
  FrameSettings one = settings;
  one.width = one.height = 1;
  FrameRenderer lender = makeFrameRenderer(device, scene, one).value();
  FrameRenderer borrower = makeFrameRenderer(device, scene, settings, &lender).value();
  for (const double time : {0.0, 0.3, 0.0}) {
    render(time);
    ASSERT_TRUE(renderFrame(device, lender, scene, time, viewAt(time)).ok());
    const auto passes = renderFrame(device, borrower, scene, time, viewAt(time));
    ASSERT_TRUE(passes.ok());
    EXPECT_TRUE(passes.value()[static_cast<std::size_t>(FramePass::composite)].skipped);
    EXPECT_FALSE(passes.value()[static_cast<std::size_t>(FramePass::pyramid)].skipped);
    EXPECT_EQ(readLinear(device, borrower).value().pixels, linear().pixels) << time;
  }
  destroyFrameRenderer(device, borrower);
  ASSERT_TRUE(renderFrame(device, lender, scene, 0.3, viewAt(0.3)).ok()) << "the volume is still the lender's";
  destroyFrameRenderer(device, lender);
}

TEST_F(Frames, ReadTheVolumeItselfWithoutAPrefilter) {
  const fs::path file = writeBakedScene(temporaryFolder());
  settings.estimator = "published";
  open(file, settings);
  EXPECT_GT(renderer.estimator.levels, 1);
  render(0.0);
  const Image filtered = linear();
  close();
  settings.prefilter = false;
  open(file, settings);
  EXPECT_EQ(renderer.estimator.levels, 1);
  render(0.0);
  EXPECT_NE(linear().pixels, filtered.pixels);
}

TEST_F(Frames, TakeRaysUnlessTapsAreAskedFor) {
  const fs::path file = writeBakedScene(temporaryFolder());
  open(file, settings);
  EXPECT_EQ(renderer.estimator.traced, 8);
  close();
  settings.taps = 4;
  open(file, settings);
  EXPECT_EQ(renderer.estimator.traced, 0);
  EXPECT_EQ(renderer.estimator.taps.size(), 4u);
  EXPECT_FALSE(renderer.estimator.steps.empty()) << "calibrated";
  close();
  settings.estimator = "published";
  open(file, settings);
  EXPECT_EQ(renderer.estimator.taps.size(), 3u) << "at 64 voxels";
  EXPECT_TRUE(renderer.estimator.steps.empty());
}

TEST_F(Frames, DarkenTheFloorUnderTheSphere) {
  open(writeBakedScene(temporaryFolder(), {.animated = true}), settings);
  const View view = lookAt({-0.7, 2.2, 4.0}, {-0.7, 0.2, 0.0}, {0, 1, 0}, 0.6);
  ASSERT_TRUE(renderFrame(device, renderer, scene, 0.0, view).ok());
  const Image low = linear();
  ASSERT_TRUE(renderFrame(device, renderer, scene, 1.0, view).ok());
  const Image high = linear();
  const int channel = channelIndex(low, "sky");
  ASSERT_GE(channel, 0);
  const auto skyAt = [&](const Image& image, const glm::dvec3& point) {
    const glm::ivec2 pixel = pixelOf(renderer, view, point);
    return at(image, pixel.x, pixel.y, channel);
  };
  std::vector<float> outward;
  for (const double d : {0.2, 0.3, 0.5, 0.7, 1.1, 1.6}) outward.push_back(skyAt(low, {-0.7, 0.0, d}));
  EXPECT_TRUE(std::is_sorted(outward.begin(), outward.end())) << "brightens outward from the contact";
  EXPECT_GT(outward.back(), outward.front() + 0.4f);
  const float contact = skyAt(low, {-0.7, 0.0, 0.3});
  EXPECT_GT(skyAt(high, {-0.7, 0.0, 0.30}), contact + 0.05f) << "the shadow lifts with the sphere";
}

TEST_F(Frames, AveragesLinearLightWhenSupersampled) {
  const fs::path file = writeBakedScene(temporaryFolder());
  open(file, {160, 90, 1, {}, {}});
  render(0.0);
  const Image fine = linear();
  close();
  open(file, {80, 45, 2, {}, {}});
  render(0.0);
  const Image coarse = linear();
  ASSERT_EQ(coarse.width, 80);
  for (int y = 0; y < 45; ++y)
    for (int x = 0; x < 80; ++x)
      for (int c = 0; c < 4; ++c) {
        float sum = 0.0f;
        for (int s = 0; s < 4; ++s) sum += at(fine, 2 * x + s % 2, 2 * y + s / 2, c);
        ASSERT_NEAR(at(coarse, x, y, c), 0.25f * sum, 1e-5f);
      }
}

TEST_F(Frames, ChangeSizeAsIfMadeAnew) {
  const fs::path file = writeBakedScene(temporaryFolder());
  open(file, {64, 48, 1, {}, {}});
  render(0.0);
  ASSERT_TRUE(resizeFrames(device, renderer, 100, 50).ok());
  render(0.0);
  const Image resized = linear();
  close();
  open(file, {100, 50, 1, {}, {}});
  render(0.0);
  EXPECT_EQ(resized.pixels, linear().pixels);
}

TEST_F(Frames, RefuseSettingsOutOfRange) {
  Result<RuntimeScene> loaded = loadScene(device, writeBakedScene(temporaryFolder()));
  ASSERT_TRUE(loaded.ok()) << message(loaded.error());
  scene = std::move(loaded).value();
  for (const FrameSettings& bad : {FrameSettings{0, 10, 1, {}, {}}, FrameSettings{16384, 10, 2, {}, {}}, FrameSettings{10, 10, 9, {}, {}},
                                   FrameSettings{10, 10, 1, 100, {}}, FrameSettings{10, 10, 1, {}, 9}})
    EXPECT_FALSE(makeFrameRenderer(device, scene, bad).ok());
}

TEST_F(Frames, ShareVolumesAndCentreMeshes) {
  open(writeBakedScene(temporaryFolder(), {.camera = true}), settings);
  EXPECT_EQ(scene.objects.size(), 4u);
  EXPECT_EQ(scene.assets.size(), 3u);
  EXPECT_NEAR(eye(viewAt(0.0)).y, 5.0, 1e-6) << "the scene's own camera";
}

TEST_F(Frames, OfPrimitivesLookLikeThoseOfVolumes) {
  const fs::path folder = temporaryFolder();
  open(writeBakedScene(folder), settings);
  render(0.0);
  const Image volumes = linear();
  close();
  Scene same = bakedScene(folder, {});
  for (Node& node : same.nodes) {
    const Box box = bounds(same.meshes[static_cast<std::size_t>(node.mesh)]);
    const PrimitiveShape shape = node.mesh == 1 ? PrimitiveShape::ellipsoid : PrimitiveShape::cuboid;
    const Primitive primitive{shape, centre(box), {1.0, 0.0, 0.0, 0.0}, 0.5 * extent(box)};
    ASSERT_TRUE(writeAsset(folder, "unused", primitive, *node.occluder).ok());
  }
  ASSERT_TRUE(writeScene(folder / "primitives.gltf", same).ok());
  open(folder / "primitives.gltf", settings);
  EXPECT_EQ(scene.assets.size(), 3u) << "nodes of the same numbers share an asset";
  render(0.0);
  const Image primitives = linear();
  double squares = 0.0;
  for (std::size_t i = 0; i < volumes.pixels.size(); ++i)
    squares += std::pow(double{volumes.pixels[i]} - double{primitives.pixels[i]}, 2.0);
  const double rms = std::sqrt(squares / static_cast<double>(volumes.pixels.size()));
  EXPECT_LT(rms, 0.05);
  EXPECT_GT(rms, 0.0) << "both scenes show the same thing";
}

class Loading : public Frames {
 protected:
  void expectError(const fs::path& file, const std::string& where, const std::string& what) {
    const Result<RuntimeScene> loaded = loadScene(device, file);
    ASSERT_FALSE(loaded.ok());
    EXPECT_NE(message(loaded.error()).find(where), std::string::npos) << message(loaded.error());
    EXPECT_NE(message(loaded.error()).find(what), std::string::npos) << message(loaded.error());
  }
};

TEST_F(Loading, SaysThatTheSceneWasNotBaked) {
  const fs::path folder = temporaryFolder();
  Scene plain = bakedScene(folder, {});
  plain.nodes[1].occluder.reset();
  ASSERT_TRUE(writeScene(folder / "plain.gltf", plain).ok());
  expectError(folder / "plain.gltf", "'sphere'", "overcast-bake");
}

TEST_F(Loading, SaysWhichVolumeIsMissingOrChanged) {
  const fs::path folder = temporaryFolder();
  const fs::path file = writeBakedScene(folder);
  std::fstream(folder / "sphere.vdb", std::ios::in | std::ios::out | std::ios::binary).seekp(200).put('\x77').put('\x78');
  expectError(file, "sphere.vdb", "hash");
  fs::remove(folder / "sphere.vdb");
  expectError(file, "sphere.vdb", "");
}

TEST_F(Loading, SaysWhichEstimatorItDoesNotKnow) {
  const fs::path folder = temporaryFolder();
  Scene other = bakedScene(folder, {});
  other.lighting->estimator.name = "palantir";
  ASSERT_TRUE(writeScene(folder / "other.gltf", other).ok());
  expectError(folder / "other.gltf", "estimator", "palantir");
}

TEST_F(Frames, OfEveryTechniqueRunWhatItNeedsAndLeaveTheSkysVisibility) {
  const fs::path file = writeBakedScene(temporaryFolder());
  for (const NamedTechnique& named : kTechniques) {
    if (named.technique == Technique::overcast) continue;
    settings.technique = {named.technique, 0.25f};
    open(file, settings);
    const std::vector<PassTime> times = render(0.0);
    const auto has = [&](const std::string& name) {
      return std::any_of(times.begin(), times.end(), [&](const PassTime& time) { return time.name == name && !time.skipped; });
    };
    for (const char* name : {"geometry", "tonemap", named.name}) EXPECT_TRUE(has(name)) << named.name << " without " << name;
    EXPECT_EQ(has("composite"), readsVolume(named.technique)) << named.name;
    EXPECT_EQ(has("denoise"), denoises(named.technique)) << named.name;
    EXPECT_FALSE(has("shade") || has("pyramid")) << named.name;
    const Image first = linear();
    const int sky = channelIndex(first, "sky");
    float darkest = 1.0f, lightest = 0.0f;
    for (std::size_t i = static_cast<std::size_t>(sky); i < first.pixels.size(); i += 4) {
      darkest = std::min(darkest, first.pixels[i]);
      lightest = std::max(lightest, first.pixels[i]);
    }
    const bool varies = named.technique != Technique::constant;
    EXPECT_GE(darkest, 0.0f) << named.name;
    EXPECT_LT(darkest, varies ? 0.2f : 0.26f) << named.name;
    EXPECT_EQ(lightest, 1.0f) << named.name << ", behind the scene";
    render(0.0);
    EXPECT_EQ(linear().pixels, first.pixels) << named.name << " has no history";
    close();
  }
  const Result<RuntimeScene> loaded = loadScene(device, file);
  ASSERT_TRUE(loaded.ok());
  scene = loaded.value();
  settings.technique = {Technique::constant, 1.5f};
  EXPECT_FALSE(makeFrameRenderer(device, scene, settings).ok()) << "more sky than there is";
}

}  // namespace
}  // namespace overcast::test
