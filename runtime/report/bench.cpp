#include "runtime/report/bench.h"

#include <algorithm>
#include <utility>

namespace overcast {
namespace {

const FrameRenderer* lenderOf(const Bench& bench, const SweepSetting& setting) {
  return readsVolume(setting.technique) ? &bench.fields.at(setting.resolution).renderer : nullptr;
}

Result<Candidate> makeOne(Bench& bench, const SweepSetting& setting) {
  const Image& image = bench.truth.pictures[0].reference.image;
  return makeCandidate(bench.device, bench.scene, setting, image.width, image.height, lenderOf(bench, setting));
}

/// A field's picture is one pixel: only its volume counts.
Result<Done> addField(Bench& bench, int resolution) {
  if (resolution == 0 || bench.fields.contains(resolution)) return Done{};
  auto field = makeCandidate(bench.device, bench.scene, raysSetting(resolution), 1, 1);
  if (!field) return field.error();
  bench.fields.emplace(resolution, std::move(field).value());
  return Done{};
}

/// The bytes of a renderer without occlusion.
Result<std::uint64_t> bytesWithout(Bench& bench, int width, int height) {
  auto plain = makeCandidate(bench.device, bench.scene, {.name = "surfaces", .technique = Technique::constant}, width, height);
  if (!plain) return plain.error();
  destroyCandidate(bench.device, plain.value());
  return plain.value().bytes;
}

std::uint64_t beyond(std::uint64_t bytes, std::uint64_t without) {
  return bytes - std::min(bytes, without);
}

}  // namespace

Result<Done> fillBench(Bench& bench, const std::vector<SweepSetting>& settings, const std::vector<int>& further) {
  const Image& image = bench.truth.pictures[0].reference.image;
  const auto plain = bytesWithout(bench, image.width, image.height), onePixel = bytesWithout(bench, 1, 1);
  if (!plain || !onePixel) return plain ? onePixel.error() : plain.error();
  bench.frameBytes = plain.value();
  Result<Done> done = Done{};
  for (const int resolution : further)
    if (done) done = addField(bench, resolution);
  for (const SweepSetting& setting : settings)
    if (done) done = addField(bench, setting.resolution);
  for (auto& [resolution, field] : bench.fields) field.bytes = beyond(field.bytes, onePixel.value());
  for (const SweepSetting& setting : settings) {
    if (!done) break;
    auto made = makeOne(bench, setting);
    if (!made) return made.error();
    bench.candidates.push_back(std::move(made).value());
  }
  return done;
}

void destroyBench(Bench& bench) {
  for (Candidate& candidate : bench.candidates) destroyCandidate(bench.device, candidate);
  for (auto& [resolution, field] : bench.fields) destroyCandidate(bench.device, field);
  bench.candidates.clear();
  bench.fields.clear();
}

Result<Done> moveFields(Bench& bench, const TruthPicture& truth) {
  const ReferenceInfo& info = truth.reference.info;
  for (auto& [resolution, field] : bench.fields) {
    const auto times = renderCandidate(bench.device, field, bench.scene, info.time, info.view);
    if (!times) return times.error();
  }
  return Done{};
}

Result<Image> pictureOf(Bench& bench, Candidate& candidate, const TruthPicture& truth) {
  const ReferenceInfo& info = truth.reference.info;
  const auto times = renderCandidate(bench.device, candidate, bench.scene, info.time, info.view);
  if (!times) return times.error();
  const auto linear = readLinear(bench.device, candidate.renderer);
  if (!linear) return linear.error();
  const Image& from = linear.value();
  const auto sky = static_cast<std::size_t>(channelIndex(from, "sky"));
  Image image{from.width, from.height, {"sky"}, {}};
  for (std::size_t i = sky; i < from.pixels.size(); i += from.channels.size()) image.pixels.push_back(from.pixels[i]);
  return image;
}

Result<Image> pictureOnce(Bench& bench, const SweepSetting& setting, const TruthPicture& truth) {
  auto candidate = makeOne(bench, setting);
  if (!candidate) return candidate.error();
  auto image = pictureOf(bench, candidate.value(), truth);
  destroyCandidate(bench.device, candidate.value());
  return image;
}

std::uint64_t deviceBytes(const Bench& bench, const Candidate& candidate) {
  const SweepSetting& setting = candidate.setting;
  std::uint64_t bytes = beyond(candidate.bytes, bench.frameBytes);
  if (readsVolume(setting.technique)) bytes += bench.fields.at(setting.resolution).bytes;
  return bytes + (setting.apertures ? bench.scene.apertures.bytes : 0);
}

}  // namespace overcast
