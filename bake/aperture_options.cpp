#include "bake/aperture_options.h"

#include <CLI/CLI.hpp>

namespace overcast {

void addApertureOptions(CLI::App& app, ApertureOptions& options) {
  app.add_option("--apertures", options.where,
                 "vertex: bake what every vertex sees of the sky past its mesh; texel: a map over its texture coordinates; none")
      ->check(CLI::IsMember({"none", "vertex", "texel"}))
      ->capture_default_str();
  app.add_option("--rays", options.rays, "rays for each point of the apertures: 128 for a look, 256, or 1024 for the final bake")
      ->check(CLI::Range(1, kMostRays))
      ->default_str(std::to_string(VisibilitySettings{}.rays));
  app.add_option("--aperture-bytes", options.bytes, "bytes of an aperture on disk: 4, or 8 for lights as small as the sun")
      ->check(CLI::IsMember({4, 8}))
      ->default_str("4");
  app.add_option("--occluders", options.occluders, "what hides the sky: self, each mesh from itself; scene, all objects that never move")
      ->check(CLI::IsMember({"self", "scene"}))
      ->default_str("self");
  app.add_option("--aperture-vertices", options.vertices,
                 "cut triangles where what is seen bends between vertices, until a mesh has so many; 0: leave meshes as they are")
      ->check(CLI::Range(0, kMostRefinedVertices))
      ->default_str("0");
  app.add_option("--texels", options.texels, "texels a side of a map of apertures")
      ->check(CLI::Range(kFewestTexels, kLargestApertureMapSide))
      ->default_str(std::to_string(kDefaultTexels));
  app.add_flag("--atlas", options.atlas, "maps over texture coordinates that are made anew, for meshes whose own overlap or are missing");
  app.add_flag("--transfer", options.transfer, "also bake the order-2 harmonics of what is visible, for sky light under any rotation");
}

Result<std::optional<SceneApertureSettings>> apertureSettings(const ApertureOptions& options) {
  const bool texel = options.where == "texel", vertex = options.where == "vertex";
  struct Detail {
    const char* name;
    bool given, fits;
    const char* needs;
  };
  const Detail details[] = {{"--rays", options.rays.has_value(), texel || vertex, "vertex or texel"},
                            {"--occluders", !options.occluders.empty(), texel || vertex, "vertex or texel"},
                            {"--aperture-bytes", options.bytes.has_value(), vertex, "vertex"},
                            {"--aperture-vertices", options.vertices.has_value(), vertex, "vertex"},
                            {"--transfer", options.transfer, vertex, "vertex"},
                            {"--texels", options.texels.has_value(), texel, "texel"},
                            {"--atlas", options.atlas, texel, "texel"}};
  for (const Detail& detail : details)
    if (detail.given && !detail.fits) return Error{"", "", fmt::format("{} needs --apertures {} (see --help)", detail.name, detail.needs)};
  if (!texel && !vertex) return std::optional<SceneApertureSettings>();
  SceneApertureSettings settings;
  if (options.rays) settings.aperture.visibility.rays = *options.rays;
  settings.aperture.visibility.transfer = options.transfer;
  if (options.bytes == 8) settings.aperture.bits = ApertureBits::packed64;
  if (options.occluders == "scene") settings.occluders = Occluding::scene;
  settings.mostVertices = static_cast<std::size_t>(options.vertices.value_or(0));
  if (!texel) return std::optional(settings);
  ApertureMapSettings& map = settings.map.emplace();
  map.visibility = settings.aperture.visibility;
  map.texels = options.texels.value_or(kDefaultTexels);
  map.atlas = options.atlas;
  return std::optional(settings);
}

}  // namespace overcast
