#include "bake/inspect_command.h"

#include <algorithm>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bake/bake_report.h"
#include "bake/command.h"
#include "bake/defects.h"
#include "bake/repair.h"
#include "formats/console.h"
#include "formats/extension_json.h"
#include "formats/files.h"
#include "formats/scene.h"
#include "formats/volume.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json toJson(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}
Json toJson(const Box& box) {
  return {{"min", toJson(box.min)}, {"max", toJson(box.max)}};
}

std::string text(const glm::dvec3& v) {
  return fmt::format("({:.6g} {:.6g} {:.6g})", v.x, v.y, v.z);
}
std::string text(const Box& box) {
  return isEmpty(box) ? "empty" : text(box.min) + " to " + text(box.max);
}

/// A document and the lines that say the same.
struct Findings {
  Json json = {{"format", "overcast-inspect"}, {"version", 1}};
  std::vector<std::string> lines;
};

void inspectVolume(const Volume& volume, Findings& findings) {
  const auto [low, high] = std::minmax_element(volume.distance.begin(), volume.distance.end());
  const auto inside = std::count_if(volume.distance.begin(), volume.distance.end(), [](float d) { return d < 0.0f; });
  findings.json["kind"] = "volume";
  findings.json["size"] = {volume.size.x, volume.size.y, volume.size.z};
  findings.json["voxelSize"] = volume.voxelSize;
  findings.json["bounds"] = toJson(bounds(volume));
  findings.json["signMethod"] = volume.signMethod;
  findings.json["step"] = volume.step;
  findings.json["minimum"] = *low;
  findings.json["maximum"] = *high;
  findings.json["inside"] = inside;
  findings.json["lipschitz"] = lipschitzBound(volume);
  findings.lines.push_back(fmt::format("volume {}x{}x{}, voxel {:.6g}, box {}", volume.size.x, volume.size.y, volume.size.z,
                                       volume.voxelSize, text(bounds(volume))));
  if (volume.step > 0.0f) findings.lines.push_back(fmt::format("8-bit distances: whole multiples of {:.6g}", volume.step));
  findings.lines.push_back(fmt::format("distances {:.6g} to {:.6g}, {} of {} samples inside, sign by {}, lipschitz {:.3f}", *low, *high,
                                       grouped(static_cast<std::uint64_t>(inside)), grouped(volume.distance.size()),
                                       volume.signMethod.empty() ? "unknown" : volume.signMethod, lipschitzBound(volume)));
}

void inspectMesh(const MeshFile& file, Findings& findings) {
  const MeshDiagnosis found = repair(file.mesh).found;
  findings.json["kind"] = "mesh";
  findings.json["vertices"] = file.mesh.positions.size();
  findings.json["faces"] = file.mesh.triangles.size();
  findings.json["bounds"] = toJson(bounds(file.mesh));
  findings.json["closed"] = found.closed;
  findings.json["components"] = found.components;
  findings.lines.push_back(fmt::format("mesh: {} vertices, {} faces, {} components, {}, box {}", grouped(file.mesh.positions.size()),
                                       grouped(file.mesh.triangles.size()), grouped(found.components), found.closed ? "closed" : "open",
                                       text(bounds(file.mesh))));
  std::vector<std::string> notes = remarks(file.report);
  MeshBake seen;
  seen.found = found;
  seen.faces = file.mesh.triangles.size();
  for (const Defect& defect : defectsOf(seen)) notes.push_back(defect.text);
  findings.json["notes"] = notes;
  for (const std::string& note : notes) findings.lines.push_back("note: " + note);
}

/// The file that holds the occluder, or its numbers.
std::string place(const Occluder& occluder) {
  if (!occluder.primitive) return occluder.uri;
  const Primitive& p = *occluder.primitive;
  return fmt::format("{} of half extents {:.4g} {:.4g} {:.4g}", name(p.shape), p.halfExtents.x, p.halfExtents.y, p.halfExtents.z);
}

std::string occluderLine(const Occluder& occluder) {
  return fmt::format("  {} {}, {} bytes, box {}, error max {:.3g} rms {:.3g}, {} sign errors in {} points, {}, from {}",
                     name(occluder.representation), place(occluder), grouped(occluder.bytes), text(occluder.bounds), occluder.error.max,
                     occluder.error.rms, grouped(occluder.error.signErrors), grouped(occluder.error.samples), occluder.signMethod,
                     occluder.source);
}

void inspectApertures(const Mesh& mesh, Json& json, Findings& findings) {
  const std::vector<Aperture>& apertures = mesh.visibility->apertures;
  double sum = 0.0;
  for (const Aperture& aperture : apertures) sum += double{aperture.radius};
  const double mean = apertures.empty() ? 0.0 : sum / static_cast<double>(apertures.size());
  const auto shut = std::count_if(apertures.begin(), apertures.end(), [](const Aperture& a) { return a.radius == 0.0f; });
  const int bytes = mesh.visibility->bits == ApertureBits::packed64 ? 8 : 4;
  const bool transfer = !mesh.visibility->transfer.empty();
  json["apertures"] = {{"vertices", apertures.size()}, {"bytes", bytes}, {"meanRadius", mean}, {"shut", shut}, {"transfer", transfer}};
  findings.lines.push_back(fmt::format("  apertures at {} vertices, {} bytes each, mean radius {:.3f} rad, {} shut{}",
                                       grouped(apertures.size()), bytes, mean, grouped(static_cast<std::uint64_t>(shut)),
                                       transfer ? ", with transfer" : ""));
}

void inspectNodes(const Scene& scene, Findings& findings) {
  Json nodes = Json::array();
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    Json json = {{"name", node.name}, {"parent", node.parent}};
    std::string line = fmt::format("node {} '{}'", i, node.name);
    if (node.mesh >= 0) {
      const Mesh& mesh = scene.meshes[static_cast<std::size_t>(node.mesh)];
      json["mesh"] = {{"name", mesh.name}, {"faces", mesh.triangles.size()}, {"bounds", toJson(bounds(mesh))}};
      line += fmt::format(", mesh '{}' of {} faces", mesh.name, grouped(mesh.triangles.size()));
      if (!node.occluder) line += ", no occluder";
      if (mesh.visibility) line += ", apertures at vertices";
      if (mesh.apertureMap) line += fmt::format(", apertures in {}", mesh.apertureMap->uri);
      if (mesh.apertureMap) json["mesh"]["apertureMap"] = Json::parse(apertureJson(*mesh.apertureMap));
    }
    if (node.camera >= 0) {
      json["camera"] = scene.cameras[static_cast<std::size_t>(node.camera)].name;
      line += ", camera";
    }
    findings.lines.push_back(line);
    if (node.mesh >= 0 && scene.meshes[static_cast<std::size_t>(node.mesh)].visibility)
      inspectApertures(scene.meshes[static_cast<std::size_t>(node.mesh)], json, findings);
    if (node.occluder) {
      json["occluder"] = Json::parse(occluderJson(*node.occluder));
      findings.lines.push_back(occluderLine(*node.occluder));
    }
    nodes.push_back(std::move(json));
  }
  findings.json["nodes"] = std::move(nodes);
}

void inspectScene(const Scene& scene, Findings& findings) {
  const auto occluders = std::count_if(scene.nodes.begin(), scene.nodes.end(), [](const Node& node) { return node.occluder.has_value(); });
  const Box box = worldBounds(scene);
  findings.json["kind"] = occluders > 0 ? "baked scene" : "scene";
  findings.json["meshes"] = scene.meshes.size();
  findings.json["cameras"] = scene.cameras.size();
  findings.json["occluders"] = occluders;
  if (!isEmpty(box)) findings.json["bounds"] = toJson(box);
  findings.lines.push_back(fmt::format("{}: {} nodes, {} meshes, {} occluders, {} cameras, world box {}",
                                       occluders > 0 ? "baked scene" : "scene", scene.nodes.size(), scene.meshes.size(), occluders,
                                       scene.cameras.size(), text(box)));
  inspectNodes(scene, findings);
  Json animations = Json::array();
  for (const Animation& animation : scene.animations)
    animations.push_back({{"name", animation.name}, {"channels", animation.channels.size()}});
  findings.json["animations"] = std::move(animations);
  findings.json["seconds"] = animationDuration(scene);
  if (!scene.animations.empty())
    findings.lines.push_back(fmt::format("{} animations, {:.3g} s", scene.animations.size(), animationDuration(scene)));
  if (scene.lighting) {
    const std::string lighting = lightingJson(*scene.lighting);
    findings.json["lighting"] = Json::parse(lighting);
    findings.lines.push_back("lighting " + lighting);
  }
  findings.json["notes"] = scene.notes;
  for (const std::string& note : scene.notes) findings.lines.push_back("note: " + note);
}

Result<Findings> inspect(const fs::path& path) {
  Findings findings;
  findings.json["file"] = path.string();
  if (path.extension() == ".vdb") {
    const auto volume = readVolume(path);
    if (!volume) return volume.error();
    inspectVolume(volume.value(), findings);
  } else if (isMeshFile(path)) {
    const auto mesh = readMesh(path);
    if (!mesh) return mesh.error();
    inspectMesh(mesh.value(), findings);
  } else if (isSceneFile(path)) {
    const auto scene = readScene(path);
    if (!scene) return scene.error();
    inspectScene(scene.value(), findings);
  } else {
    return Error{path.string(), "", "is neither a scene (.gltf .glb), a mesh (.obj .ply .stl .off) nor a volume (.vdb)"};
  }
  return findings;
}

}  // namespace

int inspectCommand(const std::vector<std::string>& arguments) {
  CLI::App app("Prints what is in a baked scene, a plain scene, a mesh or a volume.", "overcast-bake inspect");
  fs::path path;
  bool json = false;
  app.add_option("PATH", path, "a .gltf, .glb, .obj, .ply, .stl, .off or .vdb file")->required();
  app.add_flag("--json", json, "print one JSON document instead of lines");
  if (const int code = parseArguments(app, arguments); code >= 0) return code;
  const auto findings = inspect(path);
  if (!findings) {
    complain(findings.error());
    return kBadInput;
  }
  if (json) {
    printResult(findings.value().json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  } else {
    for (const std::string& line : findings.value().lines) printResult(oneLine(line) + "\n");
  }
  return kOk;
}

}  // namespace overcast
