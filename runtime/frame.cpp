#include "runtime/frame.h"

#include <algorithm>
#include <cstring>

#include "formats/view_options.h"
#include "runtime/resample.h"
#include "runtime/sky_light.h"
#include "runtime/terrain_levels.h"

namespace overcast {
namespace {

constexpr int kMaxSupersample = 8;

Result<Done> checkSettings(const FrameSettings& settings) {
  if (settings.supersample < 1 || settings.supersample > kMaxSupersample)
    return Error{"", "", fmt::format("supersampling of {} is outside 1 to {}", settings.supersample, kMaxSupersample)};
  if (!(settings.levelError >= 0.0)) return Error{"", "", fmt::format("an error of levels of {} pixels is negative", settings.levelError)};
  const int most = kMaxImageSide / settings.supersample;
  if (settings.width < 1 || settings.height < 1 || settings.width > most || settings.height > most)
    return Error{"", "", fmt::format("a picture of {}x{} is outside 1x1 to {}x{}", settings.width, settings.height, most, most)};
  if (settings.resolution && (*settings.resolution < 32 || *settings.resolution > 256 || *settings.resolution % 8 != 0))
    return Error{"", "", fmt::format("a global volume of {} voxels is not a multiple of 8 from 32 to 256", *settings.resolution)};
  if (settings.taps && (*settings.taps < 1 || *settings.taps > shared::kMaxTaps))
    return Error{"", "", fmt::format("{} taps are outside 1 to {}", *settings.taps, shared::kMaxTaps)};
  if (const float constant = settings.technique.constant; !(constant >= 0.0f && constant <= 1.0f))
    return Error{"", "", fmt::format("a sky visibility of {} is outside 0 to 1", constant)};
  if (const double radius = settings.technique.gtaoRadius.value_or(1.0); !(radius > 0.0))
    return Error{"", "", fmt::format("a radius of {} m is not above 0", radius)};
  if (const double nearness = settings.technique.surfelNearness; !(nearness > 0.0 && nearness <= 1e3))
    return Error{"", "", fmt::format("a nearness of {} radii is outside 0 to 1000", nearness)};
  return Done{};
}

/// Moves a Result's value into `into`, or hands its Error on.
template <class T>
Result<Done> take(Result<T> made, T& into) {
  if (!made) return made.error();
  into = std::move(made).value();
  return Done{};
}

void destroyTargets(const Device& device, FrameTargets& targets) {
  destroyTonemapPass(device, targets.tonemap);
  if (targets.aperture) destroyAperturePass(device, *targets.aperture);
  targets.aperture.reset();
  if (targets.baseline) destroyBaseline(device, *targets.baseline);
  targets.baseline.reset();
  destroyShadePass(device, targets.shade);
  if (targets.denoise) destroyDenoisePass(device, *targets.denoise);
  targets.denoise.reset();
  destroyImage(device, targets.light);
  destroyGeometryImages(device, targets.images);
}

/// The estimator asked for.
Estimator estimatorOf(const Lighting& lighting, const FrameSettings& settings, bool apertures) {
  const std::string_view wanted = settings.estimator ? *settings.estimator : lighting.estimator.name;
  std::string_view name = usedEstimator(wanted, apertures);
  if (settings.taps && !settings.estimator && !readsTaps(name)) name = tapsEstimator(apertures);
  Estimator estimator = withName(lighting.estimator, name);
  return settings.taps ? withTaps(std::move(estimator), *settings.taps) : estimator;
}

/// Whether pixels take turns with their samples.
bool takesTurns(const FrameRenderer& renderer) {
  const Technique technique = renderer.settings.technique.technique;
  return technique == Technique::overcast ? takesTurns(renderer.estimator) && (!renderer.apertures || renderer.rest) : denoises(technique);
}

Result<Done> makeTargets(const Device& device, FrameRenderer& renderer) {
  FrameTargets& targets = renderer.targets;
  const FrameSettings& settings = renderer.settings;
  const VkExtent2D full{static_cast<std::uint32_t>(settings.width * settings.supersample),
                        static_cast<std::uint32_t>(settings.height * settings.supersample)};
  Result<Done> done =
      take(makeGeometryImages(device, full, {renderer.apertures, renderer.transfer, renderer.rest.has_value()}), targets.images);
  const GpuBuffer* sky = renderer.sky.buffer ? &renderer.sky : nullptr;
  if (done) done = take(makeLightImage(device, targets.images), targets.light);
  if (done && takesTurns(renderer)) {
    const bool ours = settings.technique.technique == Technique::overcast;
    const int rays = renderer.estimator.traced;
    const DenoiseSettings denoise{.wide = ours, .few = ours && rays == 0, .rays = std::max(rays, 1), .sky = sky};
    done = take(makeDenoisePass(device, targets.images, targets.light, denoise), targets.denoise.emplace());
  }
  const GpuImage& light = targets.denoise ? targets.denoise->raw : targets.light;
  if (done && settings.technique.technique != Technique::overcast) {
    const BaselineInputs inputs{targets.images, light, renderer.composite.volume, renderer.surfels ? &*renderer.surfels : nullptr};
    done = take(makeBaseline(device, settings.technique, inputs), targets.baseline.emplace());
  } else if (done) {
    const PyramidPass* atRest = renderer.rest && renderer.rest->volume ? &renderer.rest->volume->pyramid : nullptr;
    done = take(makeShadePass(device, targets.images, light, renderer.pyramid, renderer.estimator, sky, atRest), targets.shade);
  }
  if (done && renderer.apertures) {
    const ApertureInputs inputs{targets.images, targets.light, renderer.manyObjects ? &renderer.pyramid : nullptr, sky};
    done = take(makeAperturePass(device, inputs, settings.apertureMode), targets.aperture.emplace());
  }
  if (done) done = take(makeTonemapPass(device, targets.light, settings.supersample, sky), targets.tonemap);
  return done;
}

const char* nameOf(FramePass pass, Technique technique) {
  switch (pass) {
    case FramePass::composite:
      return "composite";
    case FramePass::pyramid:
      return "pyramid";
    case FramePass::geometry:
      return "geometry";
    case FramePass::shade:
      return "shade";
    case FramePass::tonemap:
      return "tonemap";
    case FramePass::aperture:
      return "aperture";
    case FramePass::surfelGather:
      return "surfel-gather";
    case FramePass::denoise:
      return "denoise";
    case FramePass::baseline:
      break;
  }
  return nameOf(technique);
}

std::vector<FramePass> passesOf(const FrameRenderer& renderer) {
  const Technique technique = renderer.settings.technique.technique;
  std::vector<FramePass> passes;
  if (technique == Technique::overcast) {
    passes = {FramePass::composite, FramePass::pyramid, FramePass::geometry, FramePass::shade, FramePass::tonemap};
    if (renderer.apertures) passes.push_back(FramePass::aperture);
  } else {
    passes = {FramePass::geometry, FramePass::tonemap, FramePass::baseline};
    if (readsVolume(technique)) passes.insert(passes.begin(), FramePass::composite);
    if (technique == Technique::surfels) passes.push_back(FramePass::surfelGather);
  }
  if (takesTurns(renderer)) passes.push_back(FramePass::denoise);
  return passes;
}

Result<Done> makeSubmission(const Device& device, FrameRenderer& renderer) {
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = device.commandPool;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkResult made = vkAllocateCommandBuffers(device.device, &allocate, &renderer.commands);
  const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  if (made == VK_SUCCESS) made = vkCreateFence(device.device, &fence, nullptr, &renderer.done);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make a command buffer");
  const Technique technique = renderer.settings.technique.technique;
  renderer.passes = passesOf(renderer);
  std::vector<std::string> names;
  for (const FramePass pass : renderer.passes) names.emplace_back(nameOf(pass, technique));
  return take(makePassTimer(device, std::move(names)), renderer.timer);
}

Result<Done> makeVolume(const Device& device, const RuntimeScene& scene, FrameRenderer& renderer, const FrameRenderer* lender) {
  if (!readsVolume(renderer.settings.technique.technique)) return Done{};
  if (lender != nullptr) {
    OVERCAST_REQUIRE(lender->grid.size == renderer.grid.size, "borrows a volume of {} voxels across for one of {}", lender->grid.size.x,
                     renderer.grid.size.x);
    renderer.borrows = true;
    renderer.composite.volume = lender->composite.volume;
    return Done{};
  }
  const std::vector<double> voxels = renderer.settings.resample ? finestVoxels(scene, renderer.grid) : std::vector<double>{};
  const Result<Done> stored = take(makeAssetStore(device, scene.assets, AtlasBits::half, voxels), renderer.store);
  if (!stored) return stored;
  const auto objects = static_cast<std::uint32_t>(scene.objects.size());
  return take(makeCompositePass(device, renderer.grid, renderer.store, objects), renderer.composite);
}

Result<Done> fillRenderer(const Device& device, const RuntimeScene& scene, FrameRenderer& renderer, const FrameRenderer* lender) {
  const GlobalVolume& wanted = scene.lighting.globalVolume;
  const int resolution = renderer.settings.resolution.value_or(wanted.resolution);
  renderer.grid = globalGrid(wanted.bounds.value_or(scene.bounds), resolution);
  const Technique technique = renderer.settings.technique.technique;
  const bool wantsApertures = !renderer.settings.estimator || isHybrid(*renderer.settings.estimator);
  renderer.apertures = technique == Technique::overcast && wantsApertures && hasApertures(scene);
  renderer.transfer = renderer.apertures && hasTransfer(scene);
  renderer.manyObjects = scene.objects.size() > 1;
  const Estimator estimator = estimatorOf(scene.lighting, renderer.settings, renderer.apertures);
  Result<Done> done = take(skyEstimator(estimator, resolution), renderer.estimator);
  if (!renderer.settings.prefilter) renderer.estimator = unfiltered(std::move(renderer.estimator));
  const auto objects = static_cast<std::uint32_t>(scene.objects.size());
  if (done) done = makeVolume(device, scene, renderer, lender);
  if (done && technique == Technique::surfels)
    done = take(makeSurfelPass(device, scene, renderer.settings.technique.surfelNearness), renderer.surfels.emplace());
  if (done && technique == Technique::overcast)
    done = take(makePyramidPass(device, renderer.composite.volume, renderer.estimator.levels), renderer.pyramid);
  if (done && renderer.apertures && canChange(scene))
    done = take(makeRestVisibility(device, scene, lender ? lender->store : renderer.store, renderer.grid, renderer.estimator),
                renderer.rest.emplace());
  if (done)
    done = take(makeGeometryPass(device, scene.vertices, scene.indices, objects, renderer.apertures ? scene.apertures : GpuBuffer{},
                                 renderer.transfer ? scene.transfers : GpuBuffer{},
                                 renderer.apertures ? std::span(scene.maps) : std::span<const ApertureMapImages>(),
                                 renderer.rest ? renderer.rest->buffers : RestBuffers{}),
                renderer.geometry);
  if (done && scene.sky)
    done = take(makeBuffer(device, sizeof(shared::SkyLight), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::upload), renderer.sky);
  if (done) done = makeSubmission(device, renderer);
  if (done) done = makeTargets(device, renderer);
  return done;
}

/// Runs `record` between the timestamps of `pass`; when it returns false, the pass counts as skipped.
template <class Record>
bool timed(VkCommandBuffer commands, FrameRenderer& renderer, FramePass pass, const Record& record) {
  const auto place = std::find(renderer.passes.begin(), renderer.passes.end(), pass);
  const auto slot = static_cast<std::uint32_t>(place - renderer.passes.begin());
  beginPass(commands, renderer.timer, 0, slot);
  bool ran = true;
  if constexpr (std::is_void_v<decltype(record())>)
    record();
  else
    ran = record();
  if (ran) endPass(commands, renderer.timer, 0, slot);
  return ran;
}

/// The records of all objects at one time, for the passes that want them.
struct Placed {
  std::vector<shared::CompositeObject> occluders;
  std::vector<shared::GeometryInstance> instances;
  std::vector<shared::TransferInstance> transfers;  ///< as many, of scenes with transfer
  std::vector<glm::dmat4> worldFromCentre;          ///< each object's mesh about its centre
};

/// Sun, lamps and sky at one time.
struct Lit {
  Lighting lighting;
  SkyHarmonics sky;  ///< uniform where the scene has no image
};

Lit litAt(const RuntimeScene& scene, const std::optional<Daylight>& day, double time) {
  const double hours = day ? day->start + day->hoursPerSecond * time : 0.0;
  Lit lit{day ? lightingAt(scene.lighting, hours) : scene.lighting, {}};
  if (day && day->sunRadius) lit.lighting.sun->angularRadius = static_cast<float>(*day->sunRadius);
  if (!scene.sky) {
    lit.sky = uniformSky(lit.lighting.skyColour);
    return lit;
  }
  lit.sky = day ? tinted(*scene.sky, skyTintAt(scene.lighting, hours)) : *scene.sky;
  lit.lighting.skyColour = shared::kSkyConstant * lit.sky.coefficients[0];  // its mean, for techniques that take one colour
  return lit;
}

shared::TransferInstance transferInstance(const SceneMesh& mesh, const SkyHarmonics& sky, const glm::dmat4& worldFromLocal) {
  if (!mesh.transfer) return {};
  return {skyLight(sky, worldFromLocal), glm::ivec4(mesh.transferShift, 1, 0, 0)};
}

Placed placeObjects(const FrameRenderer& renderer, const RuntimeScene& scene, const std::vector<glm::dmat4>& nodes, const View& view,
                    const SkyHarmonics& sky) {
  Placed placed;
  for (const SceneObject& object : scene.objects) {
    const glm::dmat4& node = nodes[object.node];
    if (!renderer.store.entries.empty())
      placed.occluders.push_back(compositeObject(renderer.store.entries[object.asset], node, renderer.grid));
    glm::dmat4 fromCentre = node;
    fromCentre[3] = node * glm::dvec4(scene.meshes[object.mesh].centre, 1.0);
    placed.worldFromCentre.push_back(fromCentre);
    placed.instances.push_back(geometryInstance(fromCentre, eye(view)));
    if (renderer.transfer) placed.transfers.push_back(transferInstance(scene.meshes[object.mesh], sky, node));
  }
  return placed;
}

/// The draws of an object that has levels.
void drawLevels(const RuntimeScene& scene, std::size_t object, const glm::dmat4& node, const LevelView& view,
                std::vector<GeometryDraw>& draws) {
  const SceneMesh& mesh = scene.meshes[scene.objects[object].mesh];
  for (const TriangleRun& run : chooseLevels(*mesh.levels, node, view)) {
    GeometryDraw draw = mesh.parts.front();
    draw.firstIndex += 3 * run.first;
    draw.indexCount = 3 * run.count;
    draw.firstInstance = static_cast<std::uint32_t>(object);
    draw.instanceCount = 1;
    draws.push_back(draw);
  }
}

/// Objects are ordered by mesh, so each mesh's instances are one run.
std::vector<GeometryDraw> drawsOf(const RuntimeScene& scene, const std::vector<glm::dmat4>& nodes, const LevelView& view) {
  std::vector<GeometryDraw> draws;
  for (std::size_t first = 0; first < scene.objects.size();) {
    const SceneMesh& mesh = scene.meshes[scene.objects[first].mesh];
    std::size_t end = first;
    while (end < scene.objects.size() && scene.objects[end].mesh == scene.objects[first].mesh) ++end;
    for (std::size_t i = first; i < end && mesh.levels; ++i) drawLevels(scene, i, nodes[scene.objects[i].node], view, draws);
    for (GeometryDraw draw : mesh.parts) {
      if (mesh.levels) break;
      draw.firstInstance = static_cast<std::uint32_t>(first);
      draw.instanceCount = static_cast<std::uint32_t>(end - first);
      draws.push_back(draw);
    }
    first = end;
  }
  return draws;
}

std::uint64_t trianglesOf(const std::vector<GeometryDraw>& draws) {
  std::uint64_t triangles = 0;
  for (const GeometryDraw& draw : draws) triangles += std::uint64_t{draw.indexCount} / 3 * draw.instanceCount;
  return triangles;
}

/// What a frame is seen by.
struct Seen {
  glm::dmat4 clipFromRelative{1.0};
  glm::dvec3 eye{0.0};
};

/// Light of all pixels: by another technique than ours, through apertures where the scene has them, else from the pyramid.
void recordLight(VkCommandBuffer commands, FrameRenderer& renderer, const Lighting& lighting,
                 const std::vector<shared::ApertureLight>& lights, const Seen& seen) {
  FrameTargets& targets = renderer.targets;
  if (targets.baseline) {
    const ScreenView view{seen.clipFromRelative, seen.eye, lighting.skyColour};
    timed(commands, renderer, FramePass::baseline, [&] { recordBaseline(commands, *targets.baseline, renderer.grid, view); });
  } else if (!targets.aperture || renderer.rest) {
    const ShadeView view{seen.clipFromRelative, seen.eye, lighting.skyColour, lighting.up};
    timed(commands, renderer, FramePass::shade, [&] { recordShade(commands, targets.shade, renderer.grid, view); });
  }
  if (targets.denoise) {
    const ScreenView view{seen.clipFromRelative, seen.eye, lighting.skyColour};
    timed(commands, renderer, FramePass::denoise, [&] { recordDenoise(commands, *targets.denoise, view); });
  }
  if (targets.aperture) {
    const ApertureView view{seen.clipFromRelative, seen.eye, lighting.skyColour};
    timed(commands, renderer, FramePass::aperture, [&] { recordAperture(commands, *targets.aperture, renderer.grid, lights, view); });
  }
}

Image imageOf(const GpuImage& image, std::vector<std::string> channels) {
  Image out;
  out.width = static_cast<int>(image.extent.width);
  out.height = static_cast<int>(image.extent.height);
  out.channels = std::move(channels);
  return out;
}

}  // namespace

Result<FrameRenderer> makeFrameRenderer(const Device& device, const RuntimeScene& scene, const FrameSettings& settings,
                                        const FrameRenderer* lender) {
  const Result<Done> checked = checkSettings(settings);
  if (!checked) return checked.error();
  FrameRenderer renderer;
  renderer.settings = settings;
  const Result<Done> filled = fillRenderer(device, scene, renderer, lender);
  if (!filled) {
    destroyFrameRenderer(device, renderer);
    return filled.error();
  }
  return renderer;
}

void destroyFrameRenderer(const Device& device, FrameRenderer& renderer) {
  destroyTargets(device, renderer.targets);
  destroyPassTimer(device, renderer.timer);
  vkDestroyFence(device.device, renderer.done, nullptr);
  if (renderer.commands) vkFreeCommandBuffers(device.device, device.commandPool, 1, &renderer.commands);
  destroyGeometryPass(device, renderer.geometry);
  if (renderer.rest) destroyRestVisibility(device, *renderer.rest);
  destroyBuffer(device, renderer.sky);
  destroyPyramidPass(device, renderer.pyramid);
  if (!renderer.borrows) destroyCompositePass(device, renderer.composite);
  if (renderer.surfels) destroySurfelPass(device, *renderer.surfels);
  destroyAssetStore(device, renderer.store);
  renderer = {};
}

Result<Done> resizeFrames(const Device& device, FrameRenderer& renderer, int width, int height) {
  FrameSettings settings = renderer.settings;
  settings.width = width;
  settings.height = height;
  const Result<Done> checked = checkSettings(settings);
  if (!checked) return checked;
  renderer.settings = settings;
  destroyTargets(device, renderer.targets);
  return makeTargets(device, renderer);
}

View defaultView(const RuntimeScene& scene, double time, double aspect) {
  return chooseView(scene.scene, scene.bounds, std::nullopt, time, aspect);
}

void recordFrame(VkCommandBuffer commands, FrameRenderer& renderer, const RuntimeScene& scene, double time, const View& view) {
  const std::vector<glm::dmat4> nodes = worldFromLocal(scene.scene, time);
  const Lit lit = litAt(scene, renderer.settings.daylight, time);
  const Lighting& lighting = lit.lighting;
  const Placed placed = placeObjects(renderer, scene, nodes, view, lit.sky);
  if (renderer.sky.mapped) {
    const shared::SkyLight light = skyLight(lit.sky);
    std::memcpy(renderer.sky.mapped, &light, sizeof(light));
  }
  const double aspect = static_cast<double>(renderer.settings.width) / renderer.settings.height;
  const glm::dmat4 clip = clipFromRelative(view, aspect);
  const LevelView levels = levelView(view, aspect, renderer.settings.height, renderer.settings.levelError);
  FrameTargets& targets = renderer.targets;
  beginTimedFrame(commands, renderer.timer, 0);
  const Technique technique = renderer.settings.technique.technique;
  const std::vector<shared::ApertureLight> lights =
      targets.aperture ? apertureLights(lighting, nodes, eye(view)) : std::vector<shared::ApertureLight>();
  const bool read = readsVolume(technique) && (!targets.aperture || renderer.rest || (renderer.manyObjects && !lights.empty()));
  const auto composite = [&] { return recordComposite(commands, renderer.composite, placed.occluders); };
  const bool composited = read && (renderer.borrows || timed(commands, renderer, FramePass::composite, composite));
  if (composited && technique == Technique::overcast && (!targets.aperture || renderer.rest))
    timed(commands, renderer, FramePass::pyramid, [&] { recordPyramid(commands, renderer.pyramid); });
  const std::vector<GeometryDraw> draws = drawsOf(scene, nodes, levels);
  renderer.triangles = trianglesOf(draws);
  timed(commands, renderer, FramePass::geometry,
        [&] { recordGeometry(commands, renderer.geometry, targets.images, placed.instances, draws, glm::mat4(clip), placed.transfers); });
  if (renderer.surfels)
    timed(commands, renderer, FramePass::surfelGather,
          [&] { recordSurfels(commands, *renderer.surfels, placed.worldFromCentre, eye(view), lighting.skyColour); });
  recordLight(commands, renderer, lighting, lights, {clip, eye(view)});
  const TonemapView shown{glm::mat4(glm::inverse(clip)), lighting.skyColour, lighting.up, lighting.exposure};
  timed(commands, renderer, FramePass::tonemap, [&] { recordTonemap(commands, targets.tonemap, shown); });
}

Result<std::vector<PassTime>> renderFrame(const Device& device, FrameRenderer& renderer, const RuntimeScene& scene, double time,
                                          const View& view) {
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VkResult result = vkBeginCommandBuffer(renderer.commands, &begin);
  if (result != VK_SUCCESS) return vulkanError(result, "cannot begin a frame");
  recordFrame(renderer.commands, renderer, scene, time, view);
  result = vkEndCommandBuffer(renderer.commands);
  VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  buffer.commandBuffer = renderer.commands;
  VkSubmitInfo2 submit{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &buffer;
  if (result == VK_SUCCESS) result = vkQueueSubmit2(device.queue, 1, &submit, renderer.done);
  if (result == VK_SUCCESS) result = vkWaitForFences(device.device, 1, &renderer.done, VK_TRUE, UINT64_MAX);
  if (result == VK_SUCCESS) result = vkResetFences(device.device, 1, &renderer.done);
  if (result != VK_SUCCESS) return vulkanError(result, "cannot render a frame");
  return passTimes(device, renderer.timer, 0);
}

Result<Image> readDisplay(const Device& device, const FrameRenderer& renderer) {
  const GpuImage& display = renderer.targets.tonemap.display;
  const Result<std::vector<std::byte>> texels = readImage(device, display, kTransferRead);
  if (!texels) return texels.error();
  Image image = imageOf(display, {"R", "G", "B"});
  image.pixels.reserve(texels.value().size() / 4 * 3);
  for (std::size_t i = 0; i < texels.value().size(); ++i)
    if (i % 4 != 3) image.pixels.push_back(static_cast<float>(std::to_integer<int>(texels.value()[i])) / 255.0f);
  return image;
}

Result<Image> readLinear(const Device& device, const FrameRenderer& renderer) {
  const GpuImage& resolved = renderer.targets.tonemap.resolved;
  const Result<std::vector<std::byte>> texels = readImage(device, resolved, kTransferRead);
  if (!texels) return texels.error();
  Image image = imageOf(resolved, {"R", "G", "B", "sky"});
  image.pixels.resize(texels.value().size() / sizeof(float));
  std::memcpy(image.pixels.data(), texels.value().data(), texels.value().size());
  return image;
}

}  // namespace overcast
