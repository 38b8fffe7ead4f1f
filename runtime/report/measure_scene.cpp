#include "runtime/report/measure_scene.h"

#include <algorithm>
#include <set>

#include "runtime/report/as_printed.h"
#include "runtime/report/bench.h"
#include "runtime/report/error_split.h"
#include "runtime/report/error_sum.h"

namespace overcast {
namespace {

/// What is being measured into which scene.
struct Measurement {
  Bench& bench;
  MeasuredScene& measured;
  const MeasureSettings& settings;
  std::vector<ReportRow> rows;     ///< in the order of the candidates
  std::vector<ErrorSum> sums;      ///< likewise
  std::vector<Image> last;         ///< pictures of the last reference
  std::vector<Image> ofPublished;  ///< every picture of kPrinted
};

constexpr const char* kPrinted = "published, 4 taps, 128^3";

void say(const Measurement& m, const std::string& what) {
  if (m.settings.progress) m.settings.progress(fmt::format("{}: {}", m.measured.scene.name, what));
}

/// Narrows the masks to surfaces of the player, which a visibility of 0 everywhere shows: behind the scene it is 1.
Result<Done> narrowMasks(Bench& bench, SceneTruth& truth) {
  const SweepSetting setting{.name = "surfaces", .technique = Technique::constant, .constant = 0.0f};
  const Image& first = truth.pictures[0].reference.image;
  auto black = makeCandidate(bench.device, bench.scene, setting, first.width, first.height);
  if (!black) return black.error();
  Result<Done> done = Done{};
  for (TruthPicture& picture : truth.pictures) {
    const auto image = pictureOf(bench, black.value(), picture);
    if (!image) done = image.error();
    if (!image) break;
    for (std::size_t i = 0; i < picture.mask.size(); ++i)
      if (image.value().pixels[i] > 0.5f) picture.mask[i] = 0;
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

ReportRow rowOf(const Bench& bench, const Candidate& candidate) {
  const SweepSetting& setting = candidate.setting;
  ReportRow row;
  row.setting = setting.name;
  row.technique = nameOf(setting.technique);
  row.estimator = setting.estimator;
  row.resolution = setting.resolution;
  row.taps = setting.taps;
  row.cones = setting.cones;
  if (setting.apertures) row.apertureMode = nameOf(setting.apertureMode);
  row.storable = setting.storable;
  row.occluders = occludersOf(bench.scene);
  row.gpuBytes = deviceBytes(bench, candidate);
  if (readsVolume(setting.technique)) row.assetBytes = assetBytes(bench.scene);
  return row;
}

/// Renders and compares all references, one after the other, so that each volume is composited once for each.
Result<Done> measureErrors(Measurement& m) {
  Bench& bench = m.bench;
  m.sums.resize(bench.candidates.size());
  for (const TruthPicture& truth : bench.truth.pictures) {
    say(m, fmt::format("{} settings in frame {}", bench.candidates.size(), truth.reference.info.frame));
    if (const auto moved = moveFields(bench, truth); !moved) return moved;
    const bool isLast = &truth == &bench.truth.pictures.back();
    for (std::size_t i = 0; i < bench.candidates.size(); ++i) {
      const std::string& name = bench.candidates[i].setting.name;
      auto image = pictureOf(bench, bench.candidates[i], truth);
      if (!image) return image.error();
      if (const auto added = addPicture(m.sums[i], image.value(), truth); !added) return Error{"", name, added.error().reason};
      if (name == kPrinted) m.ofPublished.push_back(image.value());
      if (isLast) m.last.push_back(std::move(image).value());
    }
  }
  for (std::size_t i = 0; i < bench.candidates.size(); ++i) {
    m.rows.push_back(rowOf(bench, bench.candidates[i]));
    m.rows.back().errors = errorsOf(m.sums[i]);
  }
  return Done{};
}

Result<Done> measureTimes(Measurement& m) {
  say(m, "times");
  auto timing = timeCandidates(m.bench, m.bench.truth.pictures.back(), m.settings.timing);
  if (!timing) return timing.error();
  m.measured.factors.insert(m.measured.factors.end(), timing.value().factors.begin(), timing.value().factors.end());
  for (std::size_t i = 0; i < m.rows.size(); ++i) {
    RoundTimes& round = timing.value().times[i];
    m.rows[i].frame = round.frame;
    m.rows[i].still = round.still;
    m.rows[i].passes = std::move(round.passes);
  }
  return Done{};
}

/// Adds what the published estimator makes of the same taps as its paper prints it, in the same time.
Result<Done> addAsPrinted(Measurement& m) {
  const auto from = std::find_if(m.rows.begin(), m.rows.end(), [](const ReportRow& row) { return row.setting == kPrinted; });
  if (from == m.rows.end()) return Done{};
  const Estimator& estimator = m.bench.candidates[static_cast<std::size_t>(from - m.rows.begin())].lighting.estimator;
  if (!(estimator.k > 0.0f)) return Done{};
  std::vector<Image> missing;
  std::vector<const Image*> references;
  std::vector<const Mask*> masks;
  for (std::size_t i = 0; i < m.ofPublished.size(); ++i) {
    missing.push_back(missingShare(m.ofPublished[i], estimator.k, estimator.skyWeight));
    references.push_back(&m.bench.truth.pictures[i].reference.image);
    masks.push_back(&m.bench.truth.pictures[i].mask);
  }
  const double darkening = bestDarkening(missing, references, masks);
  ErrorSum sum;
  for (std::size_t i = 0; i < missing.size(); ++i) {
    missing[i] = asPrinted(missing[i], darkening);
    if (const auto added = addPicture(sum, missing[i], m.bench.truth.pictures[i]); !added) return added;
  }
  ReportRow row = *from;
  row.setting = fmt::format("{}, {} taps, {}^3, best k", kAsPrinted, row.taps, row.resolution);
  row.technique = kAsPrinted;
  row.storable = false;
  row.errors = errorsOf(sum);
  row.steps.clear();
  m.rows.push_back(std::move(row));
  m.last.push_back(std::move(missing.back()));
  return Done{};
}

Result<Done> measureAll(Measurement& m, const std::vector<SweepSetting>& settings) {
  Result<Done> done = fillBench(m.bench, settings, {kFinestVolume});
  if (done) done = measureErrors(m);
  if (done) say(m, "where the error comes from");
  if (done) done = splitErrors(m.bench, m.bench.truth.pictures.back(), m.last, m.rows);
  if (done) done = measureTimes(m);
  return done;
}

/// Hands rows and pictures over, named apart where they are of a further bake.
void keep(Measurement& m, const std::string& bake) {
  for (std::size_t i = 0; i < m.rows.size(); ++i) {
    ReportRow& row = m.rows[i];
    row.bake = bake;
    if (!bake.empty()) {
      row.setting += fmt::format(" [{}]", bake);
      row.storable = false;
    }
    m.measured.pictures.push_back({row.setting, std::move(m.last[i])});
    m.measured.scene.rows.push_back(std::move(row));
  }
}

void describe(ReportScene& scene, const SceneTruth& truth) {
  const TruthPicture& last = truth.pictures.back();
  scene.hash = truth.pictures.front().reference.info.sceneHash;
  scene.seed = last.reference.info.seed;
  scene.pictures = static_cast<int>(truth.pictures.size());
  scene.pixels = static_cast<std::uint64_t>(std::count(last.mask.begin(), last.mask.end(), 1));
  scene.referenceError = standardError(last.reference.image, last.mask);
  for (const TruthPicture& picture : truth.pictures) {
    const ReferenceInfo& info = picture.reference.info;
    scene.views.push_back({info.camera, info.frame, info.time});
  }
}

}  // namespace

std::string occludersOf(const RuntimeScene& scene) {
  int largest = 0;
  std::set<int> bits;
  std::set<std::string> others;
  for (const Asset& asset : scene.assets)
    if (const auto* volume = std::get_if<Volume>(&asset)) largest = std::max({largest, volume->size.x, volume->size.y, volume->size.z});
  for (const Node& node : scene.scene.nodes) {
    if (!node.occluder) continue;
    if (node.occluder->representation == Representation::volume)
      bits.insert(node.occluder->bits);
    else
      others.insert(name(node.occluder->representation));
  }
  std::string text;
  for (const int count : bits) text += fmt::format("{}{}", text.empty() ? "" : "/", count > 0 ? std::to_string(count) : "?");
  if (!bits.empty()) text += fmt::format(" bits, up to {} samples", largest);
  for (const std::string& other : others) text += (text.empty() ? "" : ", ") + other;
  return text;
}

Result<MeasuredScene> measureScene(const Device& device, RuntimeScene& scene, const std::string& name, SceneTruth truth,
                                   const MeasureSettings& settings) {
  OVERCAST_REQUIRE(!truth.pictures.empty(), "no reference of {}", name);
  MeasuredScene measured;
  measured.scene.name = name;
  measured.truth = std::move(truth);
  Bench bench{device, scene, measured.truth, 0, {}, {}};
  Measurement m{bench, measured, settings, {}, {}, {}, {}};
  Result<Done> done = narrowMasks(bench, measured.truth);
  if (done) done = measureAll(m, sweepSettings(scene.lighting, hasApertures(scene), settings.size));
  if (done) done = addAsPrinted(m);
  destroyBench(bench);
  if (!done) return done.error();
  describe(measured.scene, measured.truth);
  keep(m, "");
  return measured;
}

Result<Done> measureVariant(const Device& device, RuntimeScene& scene, const std::string& bake, const MeasureSettings& settings,
                            MeasuredScene& measured) {
  Bench bench{device, scene, measured.truth, 0, {}, {}};
  Measurement m{bench, measured, settings, {}, {}, {}, {}};
  const auto done = measureAll(m, sweepSettings(scene.lighting, hasApertures(scene), SweepSize::variant));
  destroyBench(bench);
  if (done) keep(m, bake);
  return done;
}

Result<std::vector<double>> timeAgain(const Device& device, RuntimeScene& scene, const MeasuredScene& measured,
                                      const MeasureSettings& settings) {
  Bench bench{device, scene, measured.truth, 0, {}, {}};
  Result<Done> done = fillBench(bench, sweepSettings(scene.lighting, hasApertures(scene), settings.size), {});
  std::vector<double> ratios;
  if (done) {
    const auto timing = timeCandidates(bench, measured.truth.pictures.back(), settings.timing);
    if (!timing) done = timing.error();
    for (std::size_t i = 0; timing && i < bench.candidates.size(); ++i) {
      const ReportRow* row = rowNamed(measured.scene, bench.candidates[i].setting.name);
      if (row != nullptr && row->still.median > 0.0) ratios.push_back(timing.value().times[i].still.median / row->still.median);
    }
  }
  destroyBench(bench);
  if (!done) return done.error();
  return ratios;
}

}  // namespace overcast
