// Scene: glTF 2.0 in memory (through tinygltf), plain or baked. A baked scene is the same thing whose mesh nodes carry an Occluder.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "formats/lighting.h"
#include "formats/mesh.h"
#include "formats/occluder.h"
#include "formats/result.h"

namespace overcast {

struct Material {
  std::string name;
  glm::vec4 baseColour{0.8f, 0.8f, 0.8f, 1.0f};  ///< linear
};

/// Perspective camera; looks along -z of its node, y up (glTF 2.0, 3.10).
struct Camera {
  std::string name;
  double verticalFieldOfView = 0.8;  ///< radians
  double nearPlane = 0.01;
};

struct Node {
  std::string name;
  int parent = -1;  ///< -1: a root
  std::vector<int> children;
  std::optional<glm::dmat4> matrix;  ///< parentFromLocal; when absent translation * rotation * scale
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};  ///< w, x, y, z; unit
  glm::dvec3 scale{1.0};
  int mesh = -1;
  int camera = -1;
  std::optional<Occluder> occluder;
};

enum class Interpolation { step, linear, cubicSpline };
enum class AnimatedProperty { translation, rotation, scale };

/// One animated property of one node. Values are xyz (w unused) or a quaternion xyzw; cubic splines hold in-tangent, value, out-tangent per
/// key.
struct AnimationChannel {
  int node = -1;
  AnimatedProperty property = AnimatedProperty::translation;
  Interpolation interpolation = Interpolation::linear;
  std::vector<double> times;  ///< seconds, strictly increasing
  std::vector<glm::dvec4> values;
};

struct Animation {
  std::string name;
  std::vector<AnimationChannel> channels;
};

struct Scene {
  std::string name;
  std::vector<Mesh> meshes;  ///< triangles only; strips and fans are turned into triangles
  std::vector<Material> materials;
  std::vector<Camera> cameras;
  std::vector<Node> nodes;  ///< the nodes reachable from the glTF's default scene
  std::vector<Animation> animations;
  std::optional<Lighting> lighting;  ///< the extension, when present
  std::vector<std::string> notes;    ///< what the reader left out or mended, one line each, for the user
};

/// True when the extension (any case) is .gltf or .glb.
bool isSceneFile(const std::filesystem::path& path);

/// Reads glTF or GLB: node hierarchy with any TRS or matrix (negative and non-uniform scale too), indexed or not, triangles, strips and
/// fans, sparse accessors, normalised integer accessors (KHR_mesh_quantization), base colours, cameras, animations of node transforms, and
/// the OVERCAST extensions. Points and lines, skins and morph targets are left out with a note. Required extensions that change geometry
/// (Draco, meshopt without fallback) are an Error. URIs that leave the file's folder are an Error. Parsed in a sandbox.
Result<Scene> readScene(const std::filesystem::path& path);

/// The files that a scene is made of: `path`, the buffers outside it and the images of its skies (other images count for nothing). Parsed
/// in a sandbox. An Error when `path` cannot be read, is no JSON object, or names one outside its folder.
Result<std::vector<std::filesystem::path>> sceneFiles(const std::filesystem::path& path);

/// A scene of one mesh file: one node with that mesh and one default material. A mesh whose box lies further from the origin than 64
/// of its diagonals is recentred, its node moved instead, so that single floats keep its detail.
Scene sceneFromMesh(Mesh mesh);

/// Writes `path` (.gltf) and beside it a .bin named <stem>-<8 hexadecimal digits of its content's hash>.bin (none for a scene without
/// meshes and animations); passes the Khronos glTF-Validator without errors. Deterministic bytes. The .gltf replaces an older one by a
/// rename when its .bin is on disk, and only then are other .bin files whose names have exactly this pattern removed: whoever kills the
/// process finds the old scene or the new one, whole. One writer at a time. Positions become single floats; missing normals are computed
/// (angle-weighted, creases over 60 degrees split). Returns the files, the scene last.
Result<std::vector<std::filesystem::path>> writeScene(const std::filesystem::path& path, const Scene& scene);

/// Removes the .bin files that older scenes at this path left, all but the one named `kept` (empty: none). What cannot be removed is
/// harmless. For whoever puts a scene in place without writeScene.
void removeOldBinaries(const std::filesystem::path& scene, const std::string& kept);

/// Applies the animations at `time` seconds (looped over the longest animation, or clamped to their ends) and returns
/// worldFromLocal of every node, in node order; [i] maps points of node i's mesh to world space.
std::vector<glm::dmat4> worldFromLocal(const Scene& scene, double time, bool loop = true);

/// Per node: 1 where an animation moves it or one of its ancestors, else 0.
std::vector<char> movingNodes(const Scene& scene);

/// Length of the longest animation in seconds; 0 when nothing moves.
double animationDuration(const Scene& scene);

/// World-space box of all mesh nodes over the whole animation (sampled at 64 times when animated).
Box worldBounds(const Scene& scene);

}  // namespace overcast
