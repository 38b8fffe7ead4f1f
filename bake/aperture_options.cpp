#include "bake/aperture_options.h"

#include <CLI/CLI.hpp>

namespace overcast {

void addApertureOptions(CLI::App& app, ApertureOptions& options) {
  app.add_option("--apertures", options.where, "vertex: bake what every vertex sees of the sky past its mesh; none")
      ->check(CLI::IsMember({"none", "vertex"}))
      ->capture_default_str();
  app.add_option("--rays", options.rays, "rays for each point of the apertures: 128 for a look, 256, or 1024 for the final bake")
      ->check(CLI::Range(1, kMostRays))
      ->capture_default_str();
  app.add_option("--aperture-bytes", options.bytes, "bytes of an aperture on disk: 4, or 8 for lights as small as the sun")
      ->check(CLI::IsMember({4, 8}))
      ->capture_default_str();
  app.add_option("--occluders", options.occluders, "what hides the sky: self, each mesh from itself; scene, all objects that never move")
      ->check(CLI::IsMember({"self", "scene"}))
      ->capture_default_str();
  app.add_flag("--transfer", options.transfer, "also bake the order-2 harmonics of what is visible, for sky light under any rotation");
}

Result<std::optional<SceneApertureSettings>> apertureSettings(const CLI::App& app, const ApertureOptions& options) {
  if (options.where == "none") {
    for (const char* detail : {"--rays", "--aperture-bytes", "--occluders", "--transfer"})
      if (app.count(detail) > 0) return Error{"", "", fmt::format("{} needs --apertures vertex (see --help)", detail)};
    return std::optional<SceneApertureSettings>();
  }
  SceneApertureSettings settings;
  settings.aperture.visibility = {options.rays, options.transfer};
  settings.occluders = options.occluders == "scene" ? Occluding::scene : Occluding::self;
  settings.aperture.bits = options.bytes == 4 ? ApertureBits::packed32 : ApertureBits::packed64;
  return std::optional(settings);
}

}  // namespace overcast
