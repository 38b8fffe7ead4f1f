#include "formats/gltf_levels.h"

#include <tiny_gltf.h>

#include "formats/gltf_accessor.h"
#include "formats/json_fields.h"

namespace overcast {
namespace {

/// The accessors that the extension names.
struct LevelAccessors {
  int indices = -1, counts = -1, own = -1, coarser = -1, balls = -1, errors = -1;
};

Result<LevelAccessors> accessorsIn(const std::string& text, const std::string& place, std::size_t accessors) {
  const Json json = Json::parse(text, nullptr, false);
  std::optional<Error> error;
  Fields fields(json, place, error);
  int version = 0;
  fields.integer("version", version, 1, kLevelsVersion);
  LevelAccessors found;
  const auto last = static_cast<int>(accessors) - 1;
  const std::pair<const char*, int*> wanted[] = {{"indices", &found.indices}, {"counts", &found.counts}, {"own", &found.own},
                                                 {"coarser", &found.coarser}, {"balls", &found.balls},   {"errors", &found.errors}};
  for (const auto& [key, accessor] : wanted) fields.integer(key, *accessor, 0, last);
  if (error) return *error;
  return found;
}

/// Clusters from three lists of numbers.
Result<std::vector<LevelCluster>> clustersOf(const tinygltf::Model& model, const LevelAccessors& from) {
  const auto counts = readIndices(model, from.counts), own = readIndices(model, from.own), coarser = readIndices(model, from.coarser);
  for (const auto* list : {&counts, &own, &coarser})
    if (!*list) return list->error();
  if (own.value().size() != counts.value().size() || coarser.value().size() != counts.value().size())
    return Error{"", "counts", "has another number of elements than own or coarser"};
  std::vector<LevelCluster> clusters;
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < counts.value().size(); ++i) {
    clusters.push_back({next, counts.value()[i], own.value()[i], coarser.value()[i]});
    if (counts.value()[i] > kNoLevelGroup - next) return Error{"", "counts", "are too many triangles"};
    next += counts.value()[i];
  }
  return clusters;
}

Result<std::vector<LevelGroup>> groupsOf(const tinygltf::Model& model, const LevelAccessors& from) {
  const auto balls = readNumbers(model, from.balls, 4), errors = readNumbers(model, from.errors, 1);
  for (const auto* list : {&balls, &errors})
    if (!*list) return list->error();
  if (balls.value().size() != 4 * errors.value().size()) return Error{"", "balls", "has another number of elements than errors"};
  std::vector<LevelGroup> groups;
  for (std::size_t g = 0; g < errors.value().size(); ++g) {
    const double* ball = &balls.value()[4 * g];
    groups.push_back({glm::vec3(ball[0], ball[1], ball[2]), static_cast<float>(ball[3]), static_cast<float>(errors.value()[g])});
  }
  return groups;
}

Result<MeshLevels> levelsOf(const tinygltf::Model& model, const LevelAccessors& from) {
  MeshLevels levels;
  auto clusters = clustersOf(model, from);
  if (!clusters) return clusters.error();
  levels.clusters = std::move(clusters).value();
  auto groups = groupsOf(model, from);
  if (!groups) return groups.error();
  levels.groups = std::move(groups).value();
  const auto indices = readIndices(model, from.indices);
  if (!indices) return indices.error();
  if (indices.value().size() % 3 != 0) return Error{"", "indices", "end in an incomplete triangle"};
  for (std::size_t i = 0; i < indices.value().size(); i += 3)
    levels.triangles.emplace_back(indices.value()[i], indices.value()[i + 1], indices.value()[i + 2]);
  return levels;
}

}  // namespace

Result<Done> readGltfLevels(const tinygltf::Model& model, const std::string& text, const std::string& place, Mesh& mesh) {
  const auto accessors = accessorsIn(text, place, model.accessors.size());
  if (!accessors) return accessors.error();
  auto levels = levelsOf(model, accessors.value());
  if (!levels) return Error{"", place + "/" + levels.error().place, levels.error().reason};
  if (mesh.parts.size() != 1) return Error{"", place, "belongs to a mesh that has not one primitive of triangles"};
  const std::string broken = brokenLevels(levels.value(), mesh.positions.size(), mesh.triangles.size());
  if (!broken.empty()) return Error{"", place, broken};
  mesh.levels = std::move(levels).value();
  return Done{};
}

}  // namespace overcast
