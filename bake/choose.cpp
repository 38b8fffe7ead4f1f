#include "bake/choose.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bake/heightfield.h"
#include "bake/primitive.h"
#include "bake/radius.h"
#include "bake/volume.h"

namespace overcast {
namespace {

constexpr double kCoarseShare = 0.125;
constexpr double kCoarseLimit = 2.0;  // times the error allowed
constexpr int kMostIdle = 2;
constexpr double kNoNearer = 0.95;  // of the excess of the size before

Error failure(std::string reason) {
  return Error{"", "", std::move(reason)};
}

/// What the candidates of one mesh have in common.
struct Source {
  const Mesh& mesh;
  const ChoiceSettings& settings;
  std::optional<Result<PrimitiveTarget>> target;  ///< once a primitive was asked for
  std::optional<Result<HeightView>> view;         ///< once a heightfield was
};

Result<Asset> volumeOf(Source& source, const Candidate& candidate, const Progress& progress) {
  VolumeSettings volume;
  volume.resolution = candidate.size;
  volume.padding = source.settings.padding;
  volume.bits = VolumeBits::single;
  volume.sheets = source.settings.sheets;
  volume.errorSamples = 0;
  auto baked = bakeVolume(source.mesh, volume, progress);
  if (!baked) return baked.error();
  return Asset(std::move(baked).value().volume);
}

Result<Asset> radiusOf(Source& source, const Candidate& candidate, const Progress& progress) {
  auto baked = bakeRadius(source.mesh, {candidate.size}, progress);
  if (!baked) return baked.error();
  return Asset(std::move(baked).value());
}

/// The same heights from behind: turned by half a turn about the first axis.
HeightView fromBehind(HeightView view) {
  view.localFromField[1] = -view.localFromField[1];
  view.localFromField[2] = -view.localFromField[2];
  return view;
}

Result<Asset> heightFieldOf(Source& source, const Candidate& candidate, const Progress&) {
  if (!source.view) source.view.emplace(bestHeightView(source.mesh));
  const Result<HeightView>& view = *source.view;
  if (!view) return view.error();
  auto baked = bakeHeightField(source.mesh, candidate.otherSide ? fromBehind(view.value()) : view.value(), candidate.size);
  if (!baked) return baked.error();
  return Asset(std::move(baked).value());
}

Result<Asset> primitiveOf(Source& source, const Candidate& candidate, const Progress& progress) {
  if (!source.target) source.target.emplace(primitiveTarget(source.mesh));
  if (!*source.target) return source.target->error();
  auto baked = fitPrimitive(source.target->value(), *candidate.shape, progress);
  if (!baked) return baked.error();
  return Asset(baked.value());
}

/// One representation: its sizes from small to large, what may be stored of each, and who makes it.
struct Ladder {
  Representation representation;
  std::optional<PrimitiveShape> shape;
  std::vector<int> sizes;
  std::vector<VolumeBits> bits;
  Result<Asset> (*bake)(Source&, const Candidate&, const Progress&);
};

/// The table of candidates: a representation joins by a row.
const std::vector<Ladder>& ladders() {
  static const std::vector<Ladder> table = {
      {Representation::primitive, PrimitiveShape::cuboid, {0}, {VolumeBits::automatic}, primitiveOf},
      {Representation::primitive, PrimitiveShape::ellipsoid, {0}, {VolumeBits::automatic}, primitiveOf},
      {Representation::radius, {}, {8, 16, 32, 64, 128}, {VolumeBits::automatic}, radiusOf},
      {Representation::heightfield, {}, {8, 16, 32, 64, 128, 256}, {VolumeBits::automatic}, heightFieldOf},
      {Representation::volume,
       {},
       {8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256},
       {VolumeBits::snorm8, VolumeBits::half, VolumeBits::single},
       volumeOf},
  };
  return table;
}

double bytesOf(const Score& score) {
  return static_cast<double>(score.bytes);
}

struct Stored {
  Asset asset;
  std::uint64_t bytes = 0;
};

/// `asset` as a runtime reads it back, and the bytes of its file. Radius and height fields are baked as stored.
Result<Stored> store(const Asset& asset, VolumeBits bits) {
  Occluder described;
  const Result<EncodedAsset> encoded = encodeAsset(asset, described, bits);
  if (!encoded) return encoded.error();
  const auto* volume = std::get_if<Volume>(&asset);
  return Stored{volume ? Asset(asStored(*volume, bits)) : asset, described.bytes};
}

/// A candidate that may still win.
struct Best {
  std::size_t score = 0;
  Asset asset;
};

/// All that one choice goes through.
class Chooser {
 public:
  Chooser(const Mesh& mesh, const ChoiceSettings& settings, const Progress& progress)
      : source_{mesh, settings, {}, {}}, settings_(settings), progress_(progress), probes_(drawProbes(mesh, settings.measure)) {
    if (settings.maxError)
      limit_ = *settings.maxError * probes_.diagonal;
    else if (!settings.maxBytes)
      limit_ = kDefaultMaxError * probes_.diagonal;
  }

  Result<Choice> run() {
    for (const Ladder& ladder : ladders()) {
      if (settings_.only && *settings_.only != ladder.representation) continue;
      if (auto climbed = climb(ladder, false); !climbed) return climbed.error();
      if (!hasOtherSide(ladder) || meetsLimits(ladder.representation)) continue;
      if (auto climbed = climb(ladder, true); !climbed) return climbed.error();
    }
    return decide();
  }

 private:
  bool limited() const { return std::isfinite(limit_); }
  bool fits(const Score& score) const { return !settings_.maxBytes || score.bytes <= *settings_.maxBytes; }

  double signShare(const Score& score) const {
    // The points near the surface are as many more as the others, in whichever share of both was measured.
    const double all = static_cast<double>(probes_.nearEnd) / static_cast<double>(settings_.measure.samples);
    return static_cast<double>(score.error.signErrors) / (static_cast<double>(score.error.samples) * all);
  }

  /// Error over error allowed, of what a light sees and of everything; within the limits up to 1.
  double lightExcess(const Score& score) const {
    return std::max(score.error.skyRmse / settings_.maxSkyError, signShare(score) / kMaxSignErrors);
  }
  /// Of a mesh with sheets, their thickness counts as error unless it was asked for.
  static double offBy(const Score& score) { return std::max(score.error.surfaceRms, score.thickened); }
  double excess(const Score& score) const { return std::max(offBy(score) / limit_, lightExcess(score)); }

  bool meetsLimits(Representation representation) const {
    return std::any_of(scores_.begin(), scores_.end(), [&](const Score& score) {
      return score.candidate.representation == representation && score.error.samples > 0 && fits(score) && excess(score) <= 1.0;
    });
  }

  /// Whether the mesh is an open sheet of heights: which side of it is solid is a matter of opinion.
  bool hasOtherSide(const Ladder& ladder) const {
    return ladder.representation == Representation::heightfield && !probes_.found.closed && source_.view && source_.view->ok() &&
           !source_.view->value().pair;
  }

  /// Tries the sizes of one representation, smallest first.
  Result<Done> climb(const Ladder& ladder, bool otherSide) {
    double last = std::numeric_limits<double>::infinity();
    int idle = 0;          // sizes in a row that came no nearer
    bool eligible = true;  // for reports, candidates that a choice would not have tried are measured all the same
    for (const int size : ladder.sizes) {
      if (size > settings_.largest) break;
      if (progress_ && !progress_(shareDone(ladder, size))) return failure("interrupted");
      Candidate candidate{ladder.representation, size, VolumeBits::automatic, ladder.shape, otherSide};
      const auto asset = ladder.bake(source_, candidate, [&](double) { return !progress_ || progress_(shareDone(ladder, size)); });
      double nearest = std::numeric_limits<double>::infinity();
      bool goOn = false;
      for (const VolumeBits bits : ladder.bits) {
        candidate.bits = bits;
        Score score{candidate, 0, {}, {}, {}};
        if (asset)
          goOn |= consider(asset.value(), std::move(score), eligible, nearest);
        else if (asset.error().reason == "interrupted")
          return asset.error();
        else
          refuse(std::move(score), asset.error().reason);
      }
      idle = limited() && nearest > kNoNearer * last ? idle + 1 : 0;
      eligible = eligible && goOn && idle < kMostIdle;
      if (!eligible && !settings_.everything) break;
      last = nearest;
    }
    return Done{};
  }

  double shareDone(const Ladder& ladder, int size) const {
    return 0.9 * static_cast<double>(size) / static_cast<double>(std::max(ladder.sizes.back(), 1));
  }

  void refuse(Score score, const std::string& reason) {
    score.reason = reason;
    scores_.push_back(std::move(score));
  }

  /// Stores and measures one candidate; true when a larger one of its kind may be worth a try. `nearest` becomes its excess if that is
  /// less. Without `eligible` it cannot win.
  bool consider(const Asset& asset, Score score, bool eligible, double& nearest) {
    auto stored = store(asset, score.candidate.bits);
    if (!stored) {
      refuse(std::move(score), stored.error().reason);
      return false;
    }
    score.bytes = stored.value().bytes;
    const Asset& made = stored.value().asset;
    score.composite = compositeCost(settings_.costs, made, score.candidate.bits);
    if (const auto* volume = std::get_if<Volume>(&made); volume && volume->sheetThickness > 0.0 && settings_.sheets.thickness == 0.0)
      score.thickened = 0.5 * volume->sheetThickness * std::sqrt(sheetShare(sheetParts(*volume, probes_)));
    score.error = measure(made, probes_, limited() ? kCoarseShare : 1.0);
    if (score.error.samples < settings_.measure.samples && excess(score) <= kCoarseLimit) score.error = measure(made, probes_);
    nearest = std::min(nearest, excess(score));
    if (settings_.everything && score.error.samples < settings_.measure.samples) score.error = measure(made, probes_);
    const bool small = fits(score), good = limited() && excess(score) <= 1.0;
    const bool dearer = within_ && bytesOf(score) > (1.0 + kSameBytes) * bytesOf(scores_[within_->score]);
    scores_.push_back(score);
    const std::size_t index = scores_.size() - 1;
    if (eligible && small && good && (!within_ || precedes(score, scores_[within_->score]))) within_ = Best{index, made};
    if (eligible && small && (!closest_ || moreAccurate(score, scores_[closest_->score]))) closest_ = Best{index, made};
    return small && !good && !dearer;
  }

  /// Whether the first of two that meet the limits is to be kept.
  bool precedes(const Score& first, const Score& second) const {
    const double one = bytesOf(first), other = bytesOf(second);
    const bool alike = std::max(one, other) <= (1.0 + kSameBytes) * std::min(one, other);
    const bool sameKind = first.candidate.representation == second.candidate.representation;
    if (alike && !sameKind && excess(first) != excess(second)) return excess(first) < excess(second);
    return one != other ? one < other : first.composite < second.composite;
  }

  /// Whether the first is to be kept where none, or nothing but bytes, is within the limits.
  bool moreAccurate(const Score& first, const Score& second) const {
    const bool one = lightExcess(first) <= 1.0, other = lightExcess(second) <= 1.0;
    return one != other ? one : offBy(first) < offBy(second);
  }

  std::string verdict(const Score& score, const Score& winner) const {
    if (!fits(score)) return fmt::format("{} bytes are more than {}", score.bytes, *settings_.maxBytes);
    if (limited() && excess(score) > 1.0) {
      if (score.error.surfaceRms > limit_) return fmt::format("{:.3g} times the error", score.error.surfaceRms / limit_);
      if (score.thickened > limit_) return "its voxels make sheets thicker than twice the error";
      if (score.error.skyRmse > settings_.maxSkyError)
        return fmt::format("{:.3g} times the error of the sky", score.error.skyRmse / settings_.maxSkyError);
      return fmt::format("{:.3g} % of the points on the wrong side", 100.0 * signShare(score));
    }
    if (!within_) return "another is more accurate";
    if (precedes(score, winner)) return "not tried: the sizes before it came no nearer";
    if (score.bytes < winner.bytes) return "meets the error, but another as small is nearer";
    return score.bytes > winner.bytes ? "meets the error, but another is smaller" : "meets the error, but another is cheaper to composite";
  }

  Result<Choice> decide() {
    std::optional<Best>& best = within_ ? within_ : closest_;
    if (!best) {
      for (const Score& score : scores_)
        if (score.bytes > 0) return failure(fmt::format("no candidate is within {} bytes", *settings_.maxBytes));
      return failure(scores_.empty() ? "there is no candidate" : scores_.front().reason);
    }
    Choice choice;
    choice.asset = std::move(best->asset);
    choice.found = probes_.found;
    choice.prepared = probes_.prepared;
    choice.ambiguousSign = probes_.ambiguousSign;
    ChoiceRecord& record = choice.record;
    record.chosen = best->score;
    record.diagonal = probes_.diagonal;
    record.withinLimits = !limited() || within_.has_value();
    Score& winner = scores_[record.chosen];
    if (winner.error.samples < settings_.measure.samples) winner.error = measure(choice.asset, probes_);
    for (Score& score : scores_)
      if (score.reason.empty()) score.reason = verdict(score, winner);
    winner.reason = record.withinLimits ? "chosen" : "chosen: the most accurate, though over the error";
    record.scores = std::move(scores_);
    return choice;
  }

  Source source_;
  const ChoiceSettings& settings_;
  const Progress& progress_;
  const Probes probes_;
  double limit_ = std::numeric_limits<double>::infinity();  ///< of surfaceRms, local units
  std::vector<Score> scores_;
  std::optional<Best> within_;   ///< the cheapest within both limits
  std::optional<Best> closest_;  ///< the most accurate within the bytes
};

}  // namespace

std::string name(const Candidate& candidate) {
  std::string text = name(candidate.representation);
  if (candidate.shape) text += fmt::format(" {}", name(*candidate.shape));
  if (candidate.size > 0) text += fmt::format(" {}", candidate.size);
  if (candidate.bits != VolumeBits::automatic) text += fmt::format(" {}", name(candidate.bits));
  if (candidate.otherSide) text += " from behind";
  return text;
}

Result<Choice> choose(const Mesh& mesh, const ChoiceSettings& settings, const Progress& progress) {
  VolumeSettings volume;
  volume.padding = settings.padding;
  if (const auto grid = volumeGrid(bounds(mesh), volume); !grid) return grid.error();
  return Chooser(mesh, settings, progress).run();
}

Result<Score> scoreOf(const Mesh& mesh, const Candidate& candidate, const ChoiceSettings& settings) {
  const auto ladder = std::find_if(ladders().begin(), ladders().end(), [&](const Ladder& row) {
    return row.representation == candidate.representation && row.shape == candidate.shape;
  });
  OVERCAST_REQUIRE(ladder != ladders().end(), "no candidate is a {}", name(candidate));
  Source source{mesh, settings, {}, {}};
  const Result<Asset> asset = ladder->bake(source, candidate, {});
  if (!asset) return asset.error();
  const Result<Stored> stored = store(asset.value(), candidate.bits);
  if (!stored) return stored.error();
  Score score{candidate, stored.value().bytes, measure(stored.value().asset, drawProbes(mesh, settings.measure)), 0.0, {}};
  score.composite = compositeCost(settings.costs, stored.value().asset, candidate.bits);
  return score;
}

}  // namespace overcast
