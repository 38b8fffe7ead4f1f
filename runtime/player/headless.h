// Headless: renders frames into picture files.
#pragma once

#include "formats/camera.h"
#include "formats/result.h"
#include "runtime/frame.h"
#include "runtime/player/command.h"
#include "runtime/player/options.h"
#include "runtime/player/report.h"
#include "runtime/scene.h"
#include "runtime/vulkan/device.h"

namespace overcast {

/// What the renderer is made with.
FrameSettings frameSettings(const PlayerOptions& options);

/// The view at `time`: --camera, else the scene's.
View viewOf(const PlayerOptions& options, const RuntimeScene& scene, double time);

/// Renders options.firstFrame .. lastFrame and writes options.outputs; `result` holds what was done, also when it failed midway.
std::optional<Failure> playHeadless(const Device& device, const RuntimeScene& scene, const PlayerOptions& options, PlayResult& result);

}  // namespace overcast
