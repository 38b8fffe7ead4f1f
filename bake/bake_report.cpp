#include "bake/bake_report.h"

#include <nlohmann/json.hpp>

namespace overcast {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

Json toJson(const MeshDiagnosis& found) {
  return {{"closed", found.closed},
          {"insideOut", found.insideOut},
          {"components", found.components},
          {"boundaryEdges", found.boundaryEdges},
          {"nonManifoldEdges", found.nonManifoldEdges},
          {"inconsistentEdges", found.inconsistentEdges},
          {"reorientedTriangles", found.reorientedTriangles},
          {"verticesMerged", found.verticesMerged},
          {"duplicateTriangles", found.duplicateTriangles},
          {"degenerateTriangles", found.degenerateTriangles}};
}

Json toJson(const BakedVolume& baked, const Occluder& occluder) {
  const Volume& volume = baked.volume;
  const MeasuredError& error = baked.error;
  return {{"representation", "volume"},
          {"uri", occluder.uri},
          {"bytes", occluder.bytes},
          {"contentHash", occluder.contentHash},
          {"size", {volume.size.x, volume.size.y, volume.size.z}},
          {"voxelSize", volume.voxelSize},
          {"bounds", {{"min", toJson(bounds(volume).min)}, {"max", toJson(bounds(volume).max)}}},
          {"signMethod", volume.signMethod},
          {"ambiguousSign", baked.ambiguousSign},
          {"lipschitz", occluder.lipschitz},
          {"error",
           {{"max", error.max},
            {"rms", error.rms},
            {"maxVoxels", error.max / volume.voxelSize},
            {"rmsVoxels", error.rms / volume.voxelSize},
            {"signErrors", error.signErrors},
            {"samples", error.samples},
            {"seed", error.seed}}}};
}

Json toJson(const SceneBake& bake, const MeshBake& mesh) {
  const MeshBake& owner = mesh.sameAs < 0 ? mesh : bake.meshes[static_cast<std::size_t>(mesh.sameAs)];
  Json json = {
      {"source", mesh.source}, {"faces", mesh.faces}, {"shared", mesh.sameAs >= 0}, {"seconds", mesh.seconds}, {"settingsHash", mesh.hash}};
  if (!owner.volume) return json;
  json["found"] = toJson(owner.volume->found);
  json["occluder"] = toJson(*owner.volume, owner.occluder);
  return json;
}

std::string count(std::uint64_t number, const char* one, const char* many) {
  return fmt::format("{} {}", grouped(number), number == 1 ? one : many);
}

}  // namespace

std::string grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t i = text.size(); i > 3;) text.insert(i -= 3, 1, ',');
  return text;
}

std::string summaryLine(const MeshBake& mesh) {
  const Volume& volume = mesh.volume->volume;
  const MeasuredError& error = mesh.volume->error;
  const std::string measured = error.samples == 0 ? "error not measured" : fmt::format("rms {:.3f} voxel", error.rms / volume.voxelSize);
  return fmt::format("{}: {}, {}x{}x{}, {:.2f} s, {}, {}, {}", mesh.source, count(mesh.faces, "face", "faces"), volume.size.x,
                     volume.size.y, volume.size.z, mesh.seconds, measured, mesh.volume->found.closed ? "closed" : "open",
                     volume.signMethod);
}

std::vector<std::string> remarks(const MeshDiagnosis& found, double ambiguousSign) {
  std::vector<std::string> lines;
  if (found.boundaryEdges > 0)
    lines.push_back(count(found.boundaryEdges, "boundary edge", "boundary edges") + ": inside is decided by the winding number");
  if (found.reorientedTriangles > 0)
    lines.push_back("turned " + count(found.reorientedTriangles, "triangle", "triangles") + " to agree with their neighbours");
  if (found.insideOut) lines.push_back("is inside out: its inside was taken as solid all the same");
  if (found.nonManifoldEdges > 0) lines.push_back(count(found.nonManifoldEdges, "edge has", "edges have") + " more than two triangles");
  if (found.duplicateTriangles > 0)
    lines.push_back("left out " + count(found.duplicateTriangles, "duplicate triangle", "duplicate triangles"));
  if (found.degenerateTriangles > 0) lines.push_back(count(found.degenerateTriangles, "triangle has", "triangles have") + " no area");
  if (ambiguousSign > 0.05)
    lines.push_back(fmt::format("inside and outside are a matter of opinion for {:.0f} % of the volume: the mesh is far from closed",
                                100.0 * ambiguousSign));
  return lines;
}

std::vector<std::string> remarks(const MeshReadReport& report) {
  std::vector<std::string> lines;
  if (report.badIndexFaces > 0)
    lines.push_back("left out " + count(report.badIndexFaces, "face", "faces") + " with an index outside the vertices");
  if (report.nonFiniteFaces > 0)
    lines.push_back("left out " + count(report.nonFiniteFaces, "face", "faces") + " with a vertex that is not finite");
  return lines;
}

std::string bakeJson(const std::vector<InputReport>& inputs, const SceneBake& bake, const std::vector<std::filesystem::path>& files,
                     double seconds) {
  Json document = {{"format", "overcast-bake"}, {"version", 1}, {"inputs", Json::array()}, {"files", Json::array()}, {"seconds", seconds}};
  for (const InputReport& input : inputs) {
    Json json = {{"file", input.path.string()}, {"notes", input.notes}, {"errors", Json::array()}, {"meshes", Json::array()}};
    for (const Error& error : input.errors)
      json["errors"].push_back({{"file", error.file}, {"place", error.place}, {"reason", error.reason}});
    for (const MeshBake& mesh : bake.meshes)
      if (bake.inputs[static_cast<std::size_t>(mesh.input)] == input.path) json["meshes"].push_back(toJson(bake, mesh));
    document["inputs"].push_back(std::move(json));
  }
  for (const std::filesystem::path& file : files) {
    std::error_code code;
    document["files"].push_back({{"path", file.string()}, {"bytes", std::filesystem::file_size(file, code)}});
  }
  return document.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace overcast
