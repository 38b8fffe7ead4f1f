#include "bake/aperture_options.h"

#include <CLI/CLI.hpp>

namespace overcast {

void addApertureOptions(CLI::App& app, ApertureOptions& options) {
  app.add_option("--apertures", options.where, "vertex: bake what every vertex sees of the sky past its mesh; none")
      ->check(CLI::IsMember({"none", "vertex"}))
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
  app.add_flag("--transfer", options.transfer, "also bake the order-2 harmonics of what is visible, for sky light under any rotation");
}

Result<std::optional<SceneApertureSettings>> apertureSettings(const ApertureOptions& options) {
  if (options.where == "none") {
    const std::pair<const char*, bool> details[] = {{"--rays", options.rays.has_value()},
                                                    {"--aperture-bytes", options.bytes.has_value()},
                                                    {"--occluders", !options.occluders.empty()},
                                                    {"--transfer", options.transfer}};
    for (const auto& [name, given] : details)
      if (given) return Error{"", "", fmt::format("{} needs --apertures vertex (see --help)", name)};
    return std::optional<SceneApertureSettings>();
  }
  SceneApertureSettings settings;
  if (options.rays) settings.aperture.visibility.rays = *options.rays;
  settings.aperture.visibility.transfer = options.transfer;
  if (options.bytes == 8) settings.aperture.bits = ApertureBits::packed64;
  if (options.occluders == "scene") settings.occluders = Occluding::scene;
  return std::optional(settings);
}

}  // namespace overcast
