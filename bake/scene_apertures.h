// Scene apertures: every mesh of a scene under bake gets apertures at its vertices.
#pragma once

#include "bake/aperture.h"
#include "bake/scene_bake.h"

namespace overcast {

/// Bakes apertures into all meshes that nodes show, one after the other on all threads, and notes the reports in SceneBake::meshes. Meshes
/// without normals get them first (formats/normals.h; creases split vertices). A mesh sees itself only, in its own space: under a node that
/// scales unevenly its apertures are approximate. Failures land in MeshBake::error. `done` is called after each mesh.
void bakeSceneApertures(SceneBake& bake, const ApertureSettings& settings, const Progress& progress = {}, const MeshDone& done = {});

}  // namespace overcast
