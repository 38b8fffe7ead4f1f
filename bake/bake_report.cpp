#include "bake/bake_report.h"

#include <map>

#include <nlohmann/json.hpp>

#include "bake/defects.h"

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
          {"turnedOutward", found.turnedOutward},
          {"verticesMerged", found.verticesMerged},
          {"duplicateTriangles", found.duplicateTriangles},
          {"degenerateTriangles", found.degenerateTriangles}};
}

Json toJson(const SurfaceReport& surface) {
  return {{"edges", surface.edges}, {"edgesChecked", surface.edgesChecked}, {"edgesPiercing", surface.edgesPiercing},
          {"thin", surface.thin},   {"thinShare", surface.thinShare},       {"innerShare", surface.innerShare}};
}

Json toJson(const MeasuredError& error) {
  return {{"max", error.max},         {"rms", error.rms},
          {"p99", error.p99},         {"surfaceRms", error.surfaceRms},
          {"skyRmse", error.skyRmse}, {"signErrors", error.signErrors},
          {"samples", error.samples}, {"seed", error.seed},
          {"method", error.method}};
}

void addVolume(Json& json, const VolumeShape& volume, const MeshBake& mesh) {
  json["size"] = {volume.size.x, volume.size.y, volume.size.z};
  json["voxelSize"] = volume.voxelSize;
  json["signMethod"] = mesh.occluder.signMethod;
  if (mesh.occluder.sheetThickness > 0.0)
    json["sheets"] = {{"thickness", mesh.occluder.sheetThickness}, {"triangles", mesh.sheetTriangles}};
  json["ambiguousSign"] = mesh.ambiguousSign;
  if (!mesh.inBox) return;
  const MeasuredError& error = *mesh.inBox;
  json["error"] = {{"max", error.max},
                   {"rms", error.rms},
                   {"maxVoxels", error.max / volume.voxelSize},
                   {"rmsVoxels", error.rms / volume.voxelSize},
                   {"signErrors", error.signErrors},
                   {"samples", error.samples},
                   {"seed", error.seed}};
}

Json occluderOf(const MeshBake& mesh) {
  const Occluder& occluder = mesh.occluder;
  const Box& box = occluder.bounds;
  Json json = {{"representation", name(occluder.representation)},
               {"uri", occluder.uri},
               {"bytes", occluder.bytes},
               {"bits", occluder.bits},
               {"contentHash", occluder.contentHash},
               {"bounds", {{"min", toJson(box.min)}, {"max", toJson(box.max)}}},
               {"lipschitz", occluder.lipschitz},
               {"inside", name(occluder.inside)}};
  if (mesh.volume) addVolume(json, *mesh.volume, mesh);
  if (occluder.error.samples > 0) json["measured"] = toJson(occluder.error);
  return json;
}

Json toJson(const Score& score) {
  Json json = {{"representation", name(score.candidate.representation)}, {"candidate", name(score.candidate)}, {"bytes", score.bytes}};
  if (score.error.samples > 0) json["measured"] = toJson(score.error);
  if (score.composite > 0.0) json["compositeNanoseconds"] = score.composite;
  json["reason"] = score.reason;
  return json;
}

Json toJson(const ChoiceRecord& record) {
  Json json = {{"diagonal", record.diagonal}, {"withinLimits", record.withinLimits}, {"chosen", record.chosen}, {"scores", Json::array()}};
  for (const Score& score : record.scores) json["scores"].push_back(toJson(score));
  return json;
}

Json toJson(const InterpolationError& error) {
  return {{"radius", error.radius}, {"ambient", error.ambient}, {"direction", error.direction}};
}

Json toJson(const ApertureReport& report) {
  return {{"vertices", report.vertices},       {"points", report.points},      {"interior", report.interior},
          {"inward", report.inward},           {"shut", report.shut},          {"rays", report.rays},
          {"seconds", report.seconds},         {"samples", report.samples},    {"fitted", report.fitted},
          {"sampled", toJson(report.sampled)}, {"error", toJson(report.error)}};
}

Json toJson(const ApertureMapReport& report) {
  return {{"width", report.size.x},
          {"height", report.size.y},
          {"traced", report.traced},
          {"covered", report.covered},
          {"overlapping", report.overlapping},
          {"charts", report.charts},
          {"interior", report.interior},
          {"shut", report.shut},
          {"rays", report.rays},
          {"seconds", report.seconds},
          {"bytes", report.bytes},
          {"levels", report.levels},
          {"samples", report.samples},
          {"error", toJson(report.error)}};
}

Json toJson(const SceneBake& bake, const MeshBake& mesh) {
  const MeshBake& owner = mesh.sameAs < 0 ? mesh : bake.meshes[static_cast<std::size_t>(mesh.sameAs)];
  Json json = {{"source", mesh.source}, {"faces", mesh.faces},     {"shared", mesh.sameAs >= 0},
               {"cached", mesh.cached}, {"seconds", mesh.seconds}, {"settingsHash", mesh.hash}};
  if (mesh.apertures) json["apertures"] = toJson(*mesh.apertures);
  if (mesh.apertureMap) json["apertureMap"] = toJson(*mesh.apertureMap);
  if (!owner.asset) return json;
  json["found"] = toJson(owner.found);
  json["surface"] = toJson(owner.surface);
  json["defects"] = Json::array();
  for (const Defect& defect : defectsOf(owner)) json["defects"].push_back({{"name", defect.name}, {"text", defect.text}});
  json["occluder"] = occluderOf(owner);
  if (owner.choice) json["choice"] = toJson(*owner.choice);
  return json;
}

}  // namespace

std::string grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t i = text.size(); i > 3;) text.insert(i -= 3, 1, ',');
  return text;
}

std::string counted(std::uint64_t number, const char* one, const char* many) {
  return fmt::format("{} {}", grouped(number), number == 1 ? one : many);
}

std::string summaryLine(const MeshBake& mesh) {
  const std::string faces = counted(mesh.faces, "face", "faces");
  const char* closed = mesh.heights ? "terrain" : mesh.found.closed ? "closed" : "open";
  const std::string time = mesh.cached ? "cached" : fmt::format("{:.2f} s", mesh.seconds);
  if (mesh.choice) {
    const Score& winner = mesh.choice->scores[mesh.choice->chosen];
    const std::string wrong =
        winner.error.signErrors == 0 ? "" : ", " + counted(winner.error.signErrors, "point", "points") + " on the wrong side";
    return fmt::format("{}: {}, {}, {} bytes, {}, surface rms {:.3g} % of the diagonal{}{}, {}", mesh.source, faces, name(winner.candidate),
                       grouped(winner.bytes), time, 100.0 * winner.error.surfaceRms / mesh.choice->diagonal,
                       mesh.choice->withinLimits ? "" : " (more than allowed: nothing does better)", wrong, closed);
  }
  const VolumeShape& volume = *mesh.volume;
  const std::string measured =
      mesh.inBox->samples == 0 ? "error not measured" : fmt::format("rms {:.3f} voxel", mesh.inBox->rms / volume.voxelSize);
  return fmt::format("{}: {}, {}x{}x{}, {}, {}, {}, {}", mesh.source, faces, volume.size.x, volume.size.y, volume.size.z, time, measured,
                     closed, mesh.occluder.signMethod);
}

std::string summaryLine(const ApertureReport& report) {
  std::string line = "apertures: " + counted(report.vertices, "vertex", "vertices");
  if (report.interior > 0) line += fmt::format(", {} in solids", grouped(report.interior));
  if (report.shut > 0) line += fmt::format(", {} shut", grouped(report.shut));
  if (report.inward > 0) line += fmt::format(", {} face inward and see the sky only from their other side", grouped(report.inward));
  line += fmt::format(", {:.2f} s", report.seconds);
  if (report.samples == 0) return line;
  line += fmt::format(", between vertices rms {:.3f} rad of radius, {:.3f} of sky light", report.error.radius, report.error.ambient);
  if (report.fitted) line += fmt::format(" (fitted; unfitted {:.3f}, {:.3f})", report.sampled.radius, report.sampled.ambient);
  return line;
}

std::string summaryLine(const ApertureMapReport& report) {
  std::string line = fmt::format("aperture map: {}x{}, {} in {}", report.size.x, report.size.y, counted(report.covered, "texel", "texels"),
                                 counted(report.charts, "chart", "charts"));
  if (report.overlapping > 0) line += fmt::format(", {} claimed twice", grouped(report.overlapping));
  if (report.interior > 0) line += fmt::format(", {} in solids", grouped(report.interior));
  if (report.shut > 0) line += fmt::format(", {} shut", grouped(report.shut));
  line += fmt::format(", {:.2f} s, {} bytes", report.seconds, grouped(report.bytes));
  if (report.samples == 0) return line;
  return line + fmt::format(", between texels rms {:.3f} rad of radius, {:.3f} of sky light", report.error.radius, report.error.ambient);
}

std::string choiceJson(const ChoiceRecord& record) {
  return toJson(record).dump();
}

std::vector<std::string> remarks(const MeshReadReport& report) {
  std::vector<std::string> lines;
  if (report.badIndexFaces > 0)
    lines.push_back("left out " + counted(report.badIndexFaces, "face", "faces") + " with an index outside the vertices");
  if (report.nonFiniteFaces > 0)
    lines.push_back("left out " + counted(report.nonFiniteFaces, "face", "faces") + " with a vertex that is not finite");
  return lines;
}

void count(RunSummary& summary, const std::vector<InputReport>& inputs, const SceneBake& bake, bool upToDate, bool planned) {
  summary.inputs += inputs.size();
  if (upToDate) summary.upToDate += inputs.size();
  for (const InputReport& input : inputs) summary.failed += !input.errors.empty();
  for (const MeshBake& mesh : bake.meshes) {
    if (mesh.sameAs >= 0 || mesh.error || !(mesh.asset || planned)) continue;
    ++(mesh.cached ? summary.meshesCached : summary.meshesBaked);
  }
}

std::string summaryLine(const RunSummary& summary) {
  return fmt::format("{}: {} baked, {} from the cache, {} up to date, {} failed; {:.1f} s, peak memory {} MB",
                     counted(summary.inputs, "input", "inputs"), counted(summary.meshesBaked, "mesh", "meshes"),
                     grouped(summary.meshesCached), counted(summary.upToDate, "input", "inputs"), grouped(summary.failed), summary.seconds,
                     summary.peakMemory >> 20);
}

JsonReport::JsonReport(Print print) : print_(std::move(print)) {}

void JsonReport::begin() {
  if (!begun_) print_("{\n  \"format\": \"overcast-bake\",\n  \"version\": 1,\n  \"inputs\": [");
  begun_ = true;
}

void JsonReport::add(const std::vector<InputReport>& inputs, const SceneBake& bake, const std::vector<std::filesystem::path>& files) {
  begin();
  std::map<std::filesystem::path, std::vector<const MeshBake*>> meshes;
  for (const MeshBake& mesh : bake.meshes) meshes[bake.inputs[static_cast<std::size_t>(mesh.input)]].push_back(&mesh);
  for (const InputReport& input : inputs) {
    Json json = {{"file", input.path.string()}, {"notes", input.notes}, {"errors", Json::array()}, {"meshes", Json::array()}};
    for (const Error& error : input.errors)
      json["errors"].push_back({{"file", error.file}, {"place", error.place}, {"reason", error.reason}});
    for (const MeshBake* mesh : meshes[input.path]) json["meshes"].push_back(toJson(bake, *mesh));
    print_((first_ ? "\n" : ",\n") + json.dump(1, ' ', false, Json::error_handler_t::replace));
    first_ = false;
  }
  files_.insert(files_.end(), files.begin(), files.end());
}

void JsonReport::finish(const RunSummary& summary, bool dryRun) {
  begin();
  Json tail = {{"files", Json::array()},
               {"dryRun", dryRun},
               {"meshesBaked", summary.meshesBaked},
               {"meshesCached", summary.meshesCached},
               {"inputsUpToDate", summary.upToDate},
               {"inputsFailed", summary.failed},
               {"peakMemory", summary.peakMemory},
               {"memoryLimit", summary.memoryLimit},
               {"seconds", summary.seconds}};
  for (const std::filesystem::path& file : files_) {
    std::error_code code;
    const auto bytes = std::filesystem::file_size(file, code);
    tail["files"].push_back({{"path", file.string()}, {"bytes", code ? Json() : Json(bytes)}});
  }
  // Without the brace that opened it: the document goes on.
  print_("\n  ]," + tail.dump(2, ' ', false, Json::error_handler_t::replace).substr(1) + "\n");
}

}  // namespace overcast
