// Reference: ray-traced truth of a scene, as `overcast-bake reference` writes it and reports read it: for each view and frame, and for
// points spread over the surfaces, a .exr of single floats and a .json beside it. Schema: formats/schema/reference.schema.json
//
// Channels of the .exr; absent are those of a quantity that was not traced. Every quantity is an average over random rays about the shading
// normal n; its standard error is the channel `<quantity>.error` (of three channels the root of the mean of their squares).
//
//   depth                   metres from the eye to the surface along the pixel's ray, of a point 0; -1: no surface, all else is then 0
//   normal.X normal.Y .Z    n in world space, unit: interpolated, turned to the viewer (a point's: outwards)
//   object                  index into Scene::nodes, -1 without a surface
//   sky                     share of the hemisphere about n, weighted by the cosine to n, in which nothing is hit: sky visibility of a
//   uniform
//                           sky all around, [0, 1]
//   dome                    the part of it that lies above the horizon (towards Lighting::up): of a dome over an open plain
//   ao                      as sky, but what is hit beyond ReferenceInfo::distanceBound counts as not hit
//   R G B                   linear radiance that the surface reflects of the sky (base colour over pi times irradiance). Directions that a
//                           light covers are not sky. Quantity "colour"
//   light.R light.G .B      reflected radiance of the sun and the area lights
//   bounce.R bounce.G .B    reflected radiance that other surfaces send here after they reflected sky, sun or lights once
//   position.X .Y .Z        of points alone: metres from ReferenceInfo::origin
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/camera.h"
#include "formats/image.h"
#include "formats/result.h"
#include "formats/scene.h"

namespace overcast {

inline constexpr int kReferenceVersion = 1;

enum class ReferenceKind {
  view,   ///< a picture: pixel centres of overcast-player --supersample 1
  points  ///< points spread evenly over the surfaces, row after row; the last row may end with depth -1
};

/// One traced quantity, over all surface pixels or points.
struct ReferenceQuantity {
  std::string name;           ///< "sky", "dome", "ao", "colour", "light" or "bounce"
  std::uint64_t samples = 0;  ///< rays for each pixel that go into it; of lights for each light
  double mean = 0.0;          ///< of three channels their mean
  double meanError = 0.0;     ///< mean standard error
  double largestError = 0.0;  ///< largest standard error
};

struct ReferenceInfo {
  ReferenceKind kind = ReferenceKind::view;
  std::string scene;        ///< the scene's file name, without folder
  std::string sceneHash;    ///< tracedHash of it
  std::string inputs;       ///< hash of all that decides what is in the file: the scene, the settings, the program
  std::string picture;      ///< name of the .exr, in the same folder
  std::string pictureHash;  ///< its content hash (formats/files.h)
  int frame = 0;
  double time = 0.0;  ///< seconds
  int width = 0;
  int height = 0;
  std::string camera;          ///< of a view: "scene" (its first camera, or one that shows all of it) or as --camera was given
  View view;                   ///< of a view
  std::uint64_t points = 0;    ///< of points: how many there are
  glm::dvec3 origin{0.0};      ///< of points: world position that their positions are relative to
  double distanceBound = 0.0;  ///< metres; 0: none, `ao` is then the same as `sky`
  double targetError = 0.0;    ///< mean standard error that was asked for (--error); 0: none
  std::uint64_t seed = 0;
  double seconds = 0.0;  ///< of tracing, on the machine at hand
  std::vector<ReferenceQuantity> quantities;
};

/// Quantity by name, or null.
const ReferenceQuantity* quantityNamed(const ReferenceInfo& info, std::string_view name);

struct Reference {
  ReferenceInfo info;
  Image image;
};

/// Hash of what rays meet in `scene` at `time` seconds: where its triangles and their normals and base colours lie, sky, sun and lights.
/// It does not change with occluders, estimator, volume and exposure, so a bake or a calibration need not trace again.
std::string tracedHash(const Scene& scene, double time);

/// Writes `json` (a path that ends in .json) and before it the picture beside it, under the same name with .exr; sets info.picture and
/// info.pictureHash. Who finds the .json finds a whole picture: a killed writer leaves the old pair, or a picture that no .json names.
Result<Done> writeReference(const std::filesystem::path& json, Reference& reference);

/// The .json alone. Errors name the field that is missing, wrong or out of range, or the version when it is a later one.
Result<ReferenceInfo> readReferenceInfo(const std::filesystem::path& json);
std::string referenceJson(const ReferenceInfo& info);
Result<ReferenceInfo> parseReferenceInfo(std::string_view json, const std::string& place);

/// Both files. Also an Error when the picture is not the one that the .json names (size, content hash), or lacks a channel.
Result<Reference> readReference(const std::filesystem::path& json);

/// All .json of references in a folder, sorted by name; others are passed over. An Error when the folder cannot be listed.
Result<std::vector<std::filesystem::path>> listReferences(const std::filesystem::path& folder);

}  // namespace overcast
