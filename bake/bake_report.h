// Bake report: what a bake found and made, as lines for people and as JSON for programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bake/scene_bake.h"

namespace overcast {

/// "bunny.off: 69,630 faces, 32x31x25, 0.12 s, rms 0.03 voxel, closed, signed-crossings", or of a chosen asset
/// "bunny.off: 69,630 faces, volume 24 half, 31,415 bytes, 0.41 s, surface rms 0.62 % of the diagonal, closed" (and, before "closed",
/// "3 points on the wrong side" where some of those measured are)
std::string summaryLine(const MeshBake& mesh);

/// "apertures: 34,817 vertices, 12 in solids, 3 shut, 0.41 s, between vertices rms 0.012 rad of radius, 0.008 of sky light"
std::string summaryLine(const ApertureReport& report);

/// The record as JSON text: diagonal, withinLimits, chosen (an index), scores.
std::string choiceJson(const ChoiceRecord& record);

/// What the user should know about how a mesh was read, one line each without its name; empty for a clean one.
std::vector<std::string> remarks(const MeshReadReport& report);

/// The number with thousands separated by commas.
std::string grouped(std::uint64_t number);

/// "1 edge", "1,234 edges".
std::string counted(std::uint64_t number, const char* one, const char* many);

/// What happened to one input besides its meshes.
struct InputReport {
  std::filesystem::path path;
  std::vector<std::string> notes;
  std::vector<Error> errors;
};

/// The document of `overcast-bake --json`, version 1: inputs (file, notes, errors, meshes), files (path, bytes), seconds.
/// Lengths are in local units of the mesh, errors also in voxels.
std::string bakeJson(const std::vector<InputReport>& inputs, const SceneBake& bake, const std::vector<std::filesystem::path>& files,
                     double seconds);

}  // namespace overcast
