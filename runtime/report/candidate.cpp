#include "runtime/report/candidate.h"

#include <utility>

namespace overcast {
namespace {

/// The scene as a candidate sees it, until the end of the block.
class Seen {
 public:
  Seen(RuntimeScene& scene, const Lighting& lighting, bool apertures)
      : scene_(scene), lighting_(scene.lighting), apertures_(scene.apertures) {
    scene_.lighting = lighting;
    if (!apertures) scene_.apertures = {};
  }
  ~Seen() {
    scene_.lighting = std::move(lighting_);
    scene_.apertures = apertures_;
  }
  Seen(const Seen&) = delete;
  Seen& operator=(const Seen&) = delete;

 private:
  RuntimeScene& scene_;
  Lighting lighting_;
  GpuBuffer apertures_;
};

}  // namespace

Result<Candidate> makeCandidate(const Device& device, RuntimeScene& scene, const SweepSetting& setting, int width, int height,
                                const FrameRenderer* lender) {
  const Lighting lighting = lightingWith(scene.lighting, setting);
  const Seen seen(scene, lighting, setting.apertures);
  const std::uint64_t before = device.allocatedBytes;
  auto renderer = makeFrameRenderer(device, scene, frameSettings(setting, width, height), lender);
  if (!renderer) return Error{renderer.error().file, setting.name, renderer.error().reason};
  return Candidate{setting, lighting, std::move(renderer).value(), device.allocatedBytes - before};
}

void destroyCandidate(const Device& device, Candidate& candidate) {
  destroyFrameRenderer(device, candidate.renderer);
}

Result<std::vector<PassTime>> renderCandidate(const Device& device, Candidate& candidate, RuntimeScene& scene, double time,
                                              const View& view) {
  const Seen seen(scene, candidate.lighting, candidate.setting.apertures);
  return renderFrame(device, candidate.renderer, scene, time, view);
}

}  // namespace overcast
