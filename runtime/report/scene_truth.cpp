#include "runtime/report/scene_truth.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace overcast {
namespace {

namespace fs = std::filesystem;

/// `folder` and the folders in it, sorted.
std::vector<fs::path> foldersIn(const fs::path& folder) {
  std::vector<fs::path> folders{folder};
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code))
    if (entry->is_directory(code)) folders.push_back(entry->path());
  std::sort(folders.begin(), folders.end());
  return folders;
}

/// The .json of all references of `scene` that `wanted` keeps.
template <class Wanted>
Result<std::vector<fs::path>> filesOf(const Scene& scene, const fs::path& folder, const Wanted& wanted) {
  std::vector<fs::path> found;
  for (const fs::path& inner : foldersIn(folder)) {
    const auto files = listReferences(inner);
    if (!files) return files.error();
    for (const fs::path& file : files.value()) {
      const auto info = readReferenceInfo(file);
      if (!info) return info.error();
      if (wanted(info.value()) && info.value().sceneHash == tracedHash(scene, info.value().time)) found.push_back(file);
    }
  }
  return found;
}

/// An Error when there is none, so that a mistyped folder is told.
template <class Wanted>
Result<std::vector<fs::path>> filesOf(const fs::path& scene, const fs::path& folder, const Wanted& wanted) {
  const auto read = readScene(scene);
  if (!read) return read.error();
  std::error_code code;
  const auto missing = Error{folder.string(), "",
                             fmt::format("has no reference of {}: trace it by overcast-bake reference {} -o {}", scene.filename().string(),
                                         scene.string(), folder.string())};
  if (!fs::is_directory(folder, code)) return missing;
  auto found = filesOf(read.value(), folder, wanted);
  if (found && found.value().empty()) return missing;
  return found;
}

Result<Reference> readWithSky(const fs::path& file) {
  auto reference = readReference(file);
  if (reference && channelIndex(reference.value().image, "sky") < 0)
    return Error{file.string(), "", "has no sky visibility: trace the quantity sky"};
  return reference;
}

Result<Done> addPicture(const fs::path& file, SceneTruth& truth) {
  auto reference = readWithSky(file);
  if (!reference) return reference.error();
  const Image& image = reference.value().image;
  if (!truth.pictures.empty()) {
    const Image& first = truth.pictures[0].reference.image;
    if (image.width != first.width || image.height != first.height)
      return Error{
          file.string(), "",
          fmt::format("is of {}x{} pixels, others of the scene are of {}x{}", image.width, image.height, first.width, first.height)};
  }
  Mask mask = surfaceMask(image);
  truth.pictures.push_back({std::move(reference).value(), std::move(mask)});
  return Done{};
}

}  // namespace

Result<SceneTruth> readTruth(const fs::path& folder, const fs::path& scene) {
  const auto views = filesOf(scene, folder, [](const ReferenceInfo& info) { return info.kind == ReferenceKind::view; });
  if (!views) return views.error();
  SceneTruth truth;
  for (const fs::path& file : views.value())
    if (const auto added = addPicture(file, truth); !added) return added.error();
  std::stable_sort(truth.pictures.begin(), truth.pictures.end(), [](const TruthPicture& a, const TruthPicture& b) {
    return std::tie(a.reference.info.camera, a.reference.info.frame) < std::tie(b.reference.info.camera, b.reference.info.frame);
  });
  return truth;
}

Result<std::vector<Reference>> readReferences(const fs::path& folder, const fs::path& scene) {
  const auto files = filesOf(scene, folder, [](const ReferenceInfo&) { return true; });
  if (!files) return files.error();
  std::vector<Reference> references;
  for (const fs::path& file : files.value()) {
    auto reference = readWithSky(file);
    if (!reference) return reference.error();
    references.push_back(std::move(reference).value());
  }
  return references;
}

double standardError(const Image& reference, const Mask& mask) {
  const int channel = channelIndex(reference, "sky.error");
  if (channel < 0) return 0.0;
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t pixel = 0; pixel < mask.size(); ++pixel) {
    if (mask[pixel] == 0) continue;
    const double error = reference.pixels[pixel * reference.channels.size() + static_cast<std::size_t>(channel)];
    squares += error * error;
    ++count;
  }
  return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.0;
}

}  // namespace overcast
