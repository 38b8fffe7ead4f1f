#include "bake/mesh_bake.h"

#include <bit>
#include <span>
#include <vector>

#include "formats/files.h"

namespace overcast {
namespace {

template <class T>
std::string bytesHash(const std::vector<T>& values) {
  return contentHash(std::as_bytes(std::span(values)));
}

/// All bits of a number.
std::string exact(double number) {
  return fmt::format("{:x}", std::bit_cast<std::uint64_t>(number));
}

// The structured bindings name every member: who adds a setting finds here that it belongs into the hash.
std::string textOf(const SheetSettings& settings) {
  const auto& [mode, thickness] = settings;
  return fmt::format("sheets {} {}", static_cast<int>(mode), exact(thickness));
}

std::string textOf(const VolumeSettings& settings) {
  const auto& [resolution, voxelSize, padding, bits, sheets, errorSamples, seed] = settings;
  return fmt::format("volume {} {} {} {} {} {} {}", resolution, exact(voxelSize), exact(padding), static_cast<int>(bits), textOf(sheets),
                     errorSamples, seed);
}

std::string textOf(const ChoiceSettings& settings) {
  const auto& [only, maxError, maxSkyError, maxBytes, largest, padding, sheets, measure, costs, everything] = settings;
  const std::string weights = compositeCostsJson(costs);
  return fmt::format("choice {} {} {} {} {} {} {} {} {} {} {}", only ? name(*only) : "any", exact(maxError.value_or(-1.0)),
                     exact(maxSkyError), maxBytes.value_or(0), largest, exact(padding), textOf(sheets), measure.samples, measure.seed,
                     contentHash(std::as_bytes(std::span(weights))), everything);
}

/// Below which thickness a part of the mesh is thin for the asset.
double thinFor(const Asset& asset, const Box& box) {
  const auto* volume = std::get_if<Volume>(&asset);
  return volume ? volume->voxelSize : 0.01 * diagonal(box);
}

/// Keeps `asset` as its file. An Error when its values do not fit the format.
Result<Done> keep(MeshBake& job, const Asset& asset, VolumeBits bits) {
  auto encoded = encodeAsset(asset, job.occluder, bits);
  if (!encoded) return encoded.error();
  if (const auto* volume = std::get_if<Volume>(&asset)) job.volume = VolumeShape{volume->size, volume->voxelSize};
  // Contact shadows fade with the size of what casts them: beyond one diagonal an object no longer darkens visibly.
  if (job.occluder.inside == Inside::unstated) job.occluder.inside = job.found.closed ? Inside::solid : Inside::open;
  job.occluder.influenceRadius = diagonal(job.occluder.bounds);
  job.occluder.settingsHash = job.hash;
  job.asset = std::move(encoded).value();
  return Done{};
}

}  // namespace

std::string settingsText(const BakeSettings& settings) {
  return fmt::format("{} {}", textOf(settings.volume), settings.choice ? textOf(*settings.choice) : "as set");
}

std::string meshHash(const Mesh& mesh, const BakeSettings& settings) {
  const std::string text =
      fmt::format("{} {} {} {}", kBakerVersion, bytesHash(mesh.positions), bytesHash(mesh.triangles), settingsText(settings));
  return contentHash(std::as_bytes(std::span(text)));
}

Result<Done> bakeMesh(MeshBake& job, const Mesh& mesh, const BakeSettings& settings, const Progress& progress) {
  if (settings.choice) {
    auto chosen = choose(mesh, *settings.choice, progress);
    if (!chosen) return chosen.error();
    Choice& choice = chosen.value();
    const Score& winner = choice.record.scores[choice.record.chosen];
    job.occluder.error = winner.error;
    job.found = choice.found;
    job.ambiguousSign = choice.ambiguousSign;
    const VolumeBits bits = winner.candidate.bits;
    job.surface = examineSurface(choice.prepared->repaired, thinFor(choice.asset, bounds(mesh)));
    job.choice = std::move(choice.record);
    return keep(job, choice.asset, bits);
  }
  auto made = bakeVolume(mesh, settings.volume, progress);
  if (!made) return made.error();
  BakedVolume& baked = made.value();
  job.found = baked.found;
  job.ambiguousSign = baked.ambiguousSign;
  job.inBox = baked.error;
  job.sheetTriangles = baked.sheetTriangles;
  const Asset asset(std::move(baked.volume));
  if (settings.volume.errorSamples > 0) {
    const Probes probes = drawProbes(mesh, {settings.volume.errorSamples, settings.volume.seed});
    job.occluder.error = measure(asset, probes);
    job.surface = examineSurface(probes.prepared->repaired, thinFor(asset, bounds(mesh)));
  }
  return keep(job, asset, settings.volume.bits);
}

}  // namespace overcast
