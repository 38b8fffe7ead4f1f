// Frame: the ordered passes that this scene needs, from a point in time to a picture:
//   transforms -> composite -> pyramid -> geometry -> shade -> tonemap
// A technique other than Overcast's own (technique.h) has its passes in place of pyramid and shade, and no global volume where it reads
// none. Composite and pyramid are skipped while nothing moves. Scenes with apertures have the aperture pass after shade, which goes on with
// what that found out about the sky (runtime/passes/shade/rest.h); where nothing can change since the bake, in its place, and without a
// volume where there are no lamps either. To other scenes it costs nothing. The same scene, time, view and settings give the same bytes on
// one device, whatever frames came before.
#pragma once

#include <optional>
#include <vector>

#include <vulkan/vulkan.h>

#include "formats/camera.h"
#include "formats/image.h"
#include "runtime/asset_store.h"
#include "runtime/baseline.h"
#include "runtime/daylight.h"
#include "runtime/passes/aperture/aperture_pass.h"
#include "runtime/passes/composite/composite_pass.h"
#include "runtime/passes/denoise/denoise_pass.h"
#include "runtime/passes/geometry/geometry_pass.h"
#include "runtime/passes/pyramid/pyramid_pass.h"
#include "runtime/passes/shade/shade_pass.h"
#include "runtime/passes/tonemap/tonemap_pass.h"
#include "runtime/rest_visibility.h"
#include "runtime/scene.h"
#include "runtime/technique.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/timer.h"

namespace overcast {

struct FrameSettings {
  int width = 1280;  ///< pixels of the picture, 1 to kMaxImageSide / supersample
  int height = 720;
  int supersample = 1;            ///< samples per pixel along a side, 1 to 8, box-filtered in linear light before tone mapping
  std::optional<int> resolution;  ///< voxels along the longest side of the global volume; else the scene's
  std::optional<int> taps;        ///< of `estimator`, or of the scene's, tapsEstimator where that reads none; else the scene's
  ApertureMode apertureMode = ApertureMode::accurate;
  std::optional<Daylight> daylight;  ///< else sun and sky stay as the scene has them
  TechniqueSettings technique;
  /// One of kEstimators; else the scene's, as usedEstimator says. One that is no hybrid leaves out the scene's apertures, and with them sun
  /// and lamps.
  std::optional<std::string> estimator = {};
  bool resample = true;     ///< radius fields and heightfields become volumes where there is room (runtime/resample.h)
  double levelError = 1.0;  ///< pixels by which meshes with levels of detail may be off (runtime/terrain_levels.h)
  bool prefilter = true;    ///< taps read the level of the pyramid that their estimator says; else all read the volume itself
};

/// The passes of a frame; renderFrame returns those that the frame may run, in this order. `baseline` is named as the technique.
enum class FramePass { composite, pyramid, geometry, shade, tonemap, aperture, surfelGather, baseline, denoise };

/// What depends on the size of the picture.
struct FrameTargets {
  GeometryImages images;
  GpuImage light;                        ///< makeLightImage
  std::optional<DenoisePass> denoise;    ///< where pixels take turns with their samples: what finds visibility writes its `raw`
  ShadePass shade;                       ///< of Technique::overcast
  std::optional<AperturePass> aperture;  ///< of Technique::overcast in scenes with apertures
  std::optional<Baseline> baseline;      ///< of other techniques
  TonemapPass tonemap;
};

/// Everything that draws one scene. One frame at a time: what a frame recorded must be done before the next is recorded.
struct FrameRenderer {
  FrameSettings settings;
  SkyEstimator estimator;
  bool apertures = false;    ///< the scene has some and the technique reads them
  bool transfer = false;     ///< and some meshes have transfer
  bool manyObjects = false;  ///< that can stand in each other's light
  bool borrows = false;      ///< composite holds nothing but the volume, which is another renderer's
  GlobalGrid grid;
  AssetStore store;
  CompositePass composite;
  std::optional<SurfelPass> surfels;  ///< of Technique::surfels
  PyramidPass pyramid;
  std::optional<RestVisibility> rest;  ///< of scenes with apertures where what is seen can change
  GeometryPass geometry;
  GpuBuffer sky;  ///< a shared::SkyLight, mapped; null: the sky is uniform
  FrameTargets targets;
  std::vector<FramePass> passes;  ///< that a frame may run, in the order of renderFrame
  PassTimer timer;
  std::uint64_t triangles = 0;  ///< that the last recorded frame's geometry pass draws
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkFence done = VK_NULL_HANDLE;
};

/// The renderer of `scene`, which must outlive it. Errors: settings out of range, an estimator we do not have, no room on the device. With
/// `lender`, a renderer of the same scene and resolution that composites and must outlive this one, it reads the lender's volume: before
/// it renders a time the lender must have rendered that time; it composites nothing and filters its pyramid anew in every frame.
Result<FrameRenderer> makeFrameRenderer(const Device& device, const RuntimeScene& scene, const FrameSettings& settings,
                                        const FrameRenderer* lender = nullptr);
void destroyFrameRenderer(const Device& device, FrameRenderer& renderer);

/// Changes the size of the pictures; the device must be idle. After an Error the renderer can only be destroyed.
Result<Done> resizeFrames(const Device& device, FrameRenderer& renderer, int width, int height);

/// The view of the scene's camera at `time`, or of the whole scene where it has none.
View defaultView(const RuntimeScene& scene, double time, double aspect);

/// Records one frame; the picture is then in targets.tonemap.display, readable by transfers (kTransferRead). The commands must be
/// submitted, in order.
void recordFrame(VkCommandBuffer commands, FrameRenderer& renderer, const RuntimeScene& scene, double time, const View& view);

/// Records and submits one frame, waits for it, and returns how long each pass took, in the order of FramePass.
Result<std::vector<PassTime>> renderFrame(const Device& device, FrameRenderer& renderer, const RuntimeScene& scene, double time,
                                          const View& view);

/// The last frame as it is shown: channels R, G, B, display-encoded, k / 255. For writePng.
Result<Image> readDisplay(const Device& device, const FrameRenderer& renderer);
/// The last frame before exposure and tone curve: channels R, G, B (linear radiance), sky (visibility of the sky, 1 behind the scene). For
/// writeExr.
Result<Image> readLinear(const Device& device, const FrameRenderer& renderer);

}  // namespace overcast
