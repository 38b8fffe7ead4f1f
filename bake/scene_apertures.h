// Scene apertures: every mesh of a scene under bake gets apertures, at its vertices or in a map over it.
#pragma once

#include <optional>
#include <string>

#include "bake/aperture.h"
#include "bake/aperture_refine.h"
#include "bake/scene_bake.h"

namespace overcast {

/// What hides the sky from a mesh: the mesh alone, or all objects that never move.
enum class Occluding { self, scene };

struct SceneApertureSettings {
  ApertureSettings aperture;               ///< at vertices
  std::optional<ApertureMapSettings> map;  ///< given: maps, and nothing at vertices
  std::size_t mostVertices = 0;            ///< at vertices: a mesh is refined (bake/aperture_refine.h) up to so many; 0: none is
  Occluding occluders = Occluding::self;
};

/// What every mesh of a scene sees: its own tree, and the trees of others as their nodes place them.
struct Stage {
  std::vector<RayScenePointer> trees;  ///< by mesh; null where no node shows it
  std::vector<glm::dmat4> world;       ///< worldFromLocal of nodes
  std::vector<int> resting;            ///< nodes that see each other
};

/// For the meshes of a baked scene; it must not change. An Error without a file, its place the mesh, when one has no extent or there is no
/// memory.
Result<Stage> setStage(const Scene& scene, Occluding occluders);

/// What is around this mesh, where anything is; the stage must outlive it. An Error without a file when memory runs out.
Result<SurroundingsPointer> surroundingsOf(const Stage& stage, const Scene& scene, int mesh);

/// All settings that change what is baked, as text: equal exactly when all of them are.
std::string settingsText(const SceneApertureSettings& settings);

/// Bakes apertures into all meshes that nodes show, one after the other on all threads, and notes the reports in SceneBake::meshes; maps
/// land in MeshBake::mapBytes and lack their uri, which writeBake fills in. Meshes
/// without normals get them first (formats/normals.h; creases split vertices). Points and directions are in the mesh's own space: under a
/// node that scales unevenly its apertures are approximate.
///
/// Refined meshes (SceneApertureSettings::mostVertices) take the place of those of the scene; occluders stay as they are.
///
/// With Occluding::scene, nodes that no animation moves see each other where they lie; nodes that move see and hide nothing but
/// themselves. A mesh that several of the resting nodes show is copied for each of them, since each sees something else; the copies share
/// the occluder. Failures land in MeshBake::error. `done` is called after each mesh.
void bakeSceneApertures(SceneBake& bake, const SceneApertureSettings& settings, const Progress& progress = {}, const MeshDone& done = {});

}  // namespace overcast
