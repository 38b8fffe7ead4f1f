#include "bake/scene_apertures.h"

#include <algorithm>

#include "formats/normals.h"

namespace overcast {
namespace {

bool isShown(const Scene& scene, int mesh) {
  return std::any_of(scene.nodes.begin(), scene.nodes.end(), [&](const Node& node) { return node.mesh == mesh; });
}

}  // namespace

void bakeSceneApertures(SceneBake& bake, const ApertureSettings& settings, const Progress& progress, const MeshDone& done) {
  const auto count = static_cast<double>(bake.meshes.size());
  for (std::size_t i = 0; i < bake.meshes.size(); ++i) {
    MeshBake& job = bake.meshes[i];
    if (job.error || !isShown(bake.scene, job.mesh)) continue;
    Mesh& mesh = bake.scene.meshes[static_cast<std::size_t>(job.mesh)];
    if (mesh.normals.empty()) mesh = withNormals(std::move(mesh));
    mendNormals(mesh);
    bool stopped = false;
    auto baked = bakeApertures(mesh, settings, [&](double share) {
      stopped = progress && !progress((static_cast<double>(i) + share) / count);
      return !stopped;
    });
    if (stopped) return;
    if (baked) {
      mesh.visibility = std::move(baked.value().visibility);
      job.apertures = baked.value().report;
    } else {
      job.error = Error{bake.inputs[static_cast<std::size_t>(job.input)].string(), mesh.name, baked.error().reason};
    }
    if (done) done(job);
  }
}

}  // namespace overcast
