#include "runtime/report/measure_scene.h"

#include <algorithm>
#include <map>
#include <set>

#include "runtime/report/candidate.h"
#include "runtime/report/error_sum.h"
#include "runtime/report/statistics.h"

namespace overcast {
namespace {

constexpr int kFinest = 256;  // voxels of the volume that stands for the local occluders themselves

/// All that is measured together; candidates are destroyed with it.
struct Bench {
  const Device& device;
  RuntimeScene& scene;
  SceneTruth truth;
  const MeasureSettings& settings;
  std::vector<Candidate> candidates;

  ~Bench() {
    for (Candidate& candidate : candidates) destroyCandidate(device, candidate);
  }
};

void say(const Bench& bench, const std::string& what) {
  if (bench.settings.progress) bench.settings.progress(what);
}

const Image& firstImage(const Bench& bench) {
  return bench.truth.pictures[0].reference.image;
}

/// What `candidate` makes of a reference: channel sky.
Result<Image> pictureOf(const Bench& bench, Candidate& candidate, const TruthPicture& truth) {
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

/// The picture of a setting that is not kept.
Result<Image> pictureOnce(const Bench& bench, const SweepSetting& setting) {
  auto candidate = makeCandidate(bench.device, bench.scene, setting, firstImage(bench).width, firstImage(bench).height);
  if (!candidate) return candidate.error();
  auto image = pictureOf(bench, candidate.value(), bench.truth.pictures[0]);
  destroyCandidate(bench.device, candidate.value());
  return image;
}

/// Narrows the masks to surfaces of the player, which a visibility of 0 everywhere shows: behind the scene it is 1.
Result<Done> narrowMasks(Bench& bench, std::uint64_t& bytes) {
  SweepSetting setting{.name = "surfaces", .technique = Technique::constant, .constant = 0.0f};
  auto black = makeCandidate(bench.device, bench.scene, setting, firstImage(bench).width, firstImage(bench).height);
  if (!black) return black.error();
  bytes = black.value().bytes;
  Result<Done> done = Done{};
  for (TruthPicture& truth : bench.truth.pictures) {
    const auto image = pictureOf(bench, black.value(), truth);
    if (!image) done = image.error();
    if (!image) break;
    for (std::size_t i = 0; i < truth.mask.size(); ++i)
      if (image.value().pixels[i] > 0.5f) truth.mask[i] = 0;
  }
  destroyCandidate(bench.device, black.value());
  return done;
}

/// Of the scene's files, those that a setting that reads the volume needs.
std::uint64_t assetBytes(const RuntimeScene& scene) {
  std::set<std::string> seen;
  std::uint64_t bytes = 0;
  for (const Node& node : scene.scene.nodes)
    if (node.occluder && (node.occluder->uri.empty() || seen.insert(node.occluder->uri).second)) bytes += node.occluder->bytes;
  return bytes;
}

/// "16 bits, up to 64 samples" and the like.
std::string occludersOf(const RuntimeScene& scene) {
  int largest = 0;
  std::set<int> bits;
  for (const Asset& asset : scene.assets)
    if (const auto* volume = std::get_if<Volume>(&asset)) largest = std::max({largest, volume->size.x, volume->size.y, volume->size.z});
  for (const Node& node : scene.scene.nodes)
    if (node.occluder && node.occluder->representation == Representation::volume) bits.insert(node.occluder->bits);
  if (largest == 0) return "no volumes";
  std::string text;
  for (const int count : bits) text += fmt::format("{}{}", text.empty() ? "" : "/", count > 0 ? std::to_string(count) : "?");
  return fmt::format("{} bits, up to {} samples", text, largest);
}

ReportRow rowOf(const Bench& bench, const Candidate& candidate, std::uint64_t frameBytes) {
  const SweepSetting& setting = candidate.setting;
  ReportRow row;
  row.setting = setting.name;
  row.technique = nameOf(setting.technique);
  row.estimator = setting.estimator;
  row.resolution = setting.resolution;
  row.taps = setting.taps;
  if (setting.apertures) row.apertureMode = nameOf(setting.apertureMode);
  row.storable = setting.storable;
  row.occluders = occludersOf(bench.scene);
  row.gpuBytes = candidate.bytes - std::min(candidate.bytes, frameBytes) + (setting.apertures ? bench.scene.apertures.bytes : 0);
  if (readsVolume(setting.technique)) row.assetBytes = assetBytes(bench.scene);
  return row;
}

/// Makes the candidate of `setting`, renders and compares all references, and keeps it for timing.
Result<Done> measureErrors(Bench& bench, const SweepSetting& setting, std::uint64_t frameBytes, MeasuredScene& measured) {
  auto made = makeCandidate(bench.device, bench.scene, setting, firstImage(bench).width, firstImage(bench).height);
  if (!made) return made.error();
  Candidate& candidate = bench.candidates.emplace_back(std::move(made).value());
  ErrorSum sum;
  for (const TruthPicture& truth : bench.truth.pictures) {
    auto image = pictureOf(bench, candidate, truth);
    if (!image) return image.error();
    const auto added = addPicture(sum, image.value(), truth);
    if (!added) return Error{"", setting.name, added.error().reason};
    if (&truth == &bench.truth.pictures[0]) measured.pictures.push_back({setting.name, std::move(image).value()});
  }
  ReportRow row = rowOf(bench, candidate, frameBytes);
  row.errors = errorsOf(sum);
  measured.scene.rows.push_back(std::move(row));
  return Done{};
}

/// Tells apart where the error of our estimators comes from, by pictures that make one approximation more each.
Result<Done> splitErrors(const Bench& bench, MeasuredScene& measured) {
  const std::vector<std::string> sky{"sky"};
  const auto finest = pictureOnce(bench, raysSetting(kFinest));
  if (!finest) return finest.error();
  std::map<int, Image> rays;
  for (std::size_t i = 0; i < measured.scene.rows.size(); ++i) {
    ReportRow& row = measured.scene.rows[i];
    if (row.technique != nameOf(Technique::overcast)) continue;
    if (!rays.contains(row.resolution)) {
      auto image = row.resolution == kFinest ? finest : pictureOnce(bench, raysSetting(row.resolution));
      if (!image) return image.error();
      rays.emplace(row.resolution, std::move(image).value());
    }
    const Image* const chain[] = {&firstImage(bench), &finest.value(), &rays.at(row.resolution), &measured.pictures[i].image};
    const auto steps = splitError(chain, sky, bench.truth.pictures[0].mask);
    if (!steps) return steps.error();
    const char* const names[] = {"occluders, by rays at 256^3", "composite at fewer voxels", "filter and estimator"};
    for (std::size_t s = 0; s < steps.value().size(); ++s) {
      const ErrorStep& step = steps.value()[s];
      row.steps.push_back({names[s], step.rms, step.bias, step.share});
    }
  }
  return Done{};
}

/// Times all candidates, round by round.
Result<Done> measureTimes(Bench& bench, MeasuredScene& measured) {
  const MeasureSettings& settings = bench.settings;
  const ReferenceInfo& info = bench.truth.pictures[0].reference.info;
  for (Candidate& candidate : bench.candidates) {
    const auto resized = resizeFrames(bench.device, candidate.renderer, settings.timedWidth, settings.timedHeight);
    if (!resized) return resized;
  }
  std::vector<std::vector<std::vector<PassTime>>> times(bench.candidates.size());
  for (int round = -1; round < settings.rounds; ++round) {
    for (std::size_t step = 0; step < bench.candidates.size(); ++step) {
      const std::size_t i = round % 2 == 0 ? step : bench.candidates.size() - 1 - step;
      auto frame = renderCandidate(bench.device, bench.candidates[i], bench.scene, info.time, info.view);
      if (!frame) return frame.error();
      if (round >= 0) times[i].push_back(std::move(frame).value());
    }
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    RoundTimes round = timesOf(times[i]);
    measured.scene.rows[i].frame = round.frame;
    measured.scene.rows[i].still = round.still;
    measured.scene.rows[i].passes = std::move(round.passes);
  }
  return Done{};
}

Result<Done> measureAll(Bench& bench, MeasuredScene& measured) {
  std::uint64_t frameBytes = 0;
  Result<Done> done = narrowMasks(bench, frameBytes);
  const TruthPicture& first = bench.truth.pictures[0];
  measured.scene.pixels = static_cast<std::uint64_t>(std::count(first.mask.begin(), first.mask.end(), 1));
  measured.scene.referenceError = standardError(first.reference.image, first.mask);
  const auto sweep = sweepSettings(bench.scene.lighting, hasApertures(bench.scene), bench.settings.quick);
  for (const SweepSetting& setting : sweep) {
    if (done) say(bench, fmt::format("{}: error of {}", measured.scene.name, setting.name));
    if (done) done = measureErrors(bench, setting, frameBytes, measured);
  }
  if (done) say(bench, fmt::format("{}: where the error comes from", measured.scene.name));
  if (done) done = splitErrors(bench, measured);
  if (done) say(bench, fmt::format("{}: {} rounds of times", measured.scene.name, bench.settings.rounds));
  return done ? measureTimes(bench, measured) : done;
}

}  // namespace

Result<MeasuredScene> measureScene(const Device& device, RuntimeScene& scene, const std::string& name, SceneTruth truth,
                                   const MeasureSettings& settings) {
  OVERCAST_REQUIRE(!truth.pictures.empty(), "no reference of {}", name);
  Bench bench{device, scene, std::move(truth), settings, {}};
  const ReferenceInfo& info = bench.truth.pictures[0].reference.info;
  MeasuredScene measured;
  measured.scene.name = name;
  measured.scene.hash = info.sceneHash;
  measured.scene.seed = info.seed;
  measured.scene.pictures = static_cast<int>(bench.truth.pictures.size());
  const auto done = measureAll(bench, measured);
  if (!done) return done.error();
  measured.truth = std::move(bench.truth.pictures[0]);
  return measured;
}

}  // namespace overcast
