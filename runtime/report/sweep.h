// Sweep: the settings that a report compares in each scene.
#pragma once

#include <string>
#include <vector>

#include "formats/lighting.h"
#include "runtime/frame.h"
#include "runtime/technique.h"

namespace overcast {

struct SweepSetting {
  std::string name;  ///< the same in every scene
  Technique technique = Technique::overcast;
  std::string estimator;   ///< of Technique::overcast
  int taps = 0;            ///< of Technique::overcast; 0: the estimator reads none
  int cones = 0;           ///< of an estimator that has some; 0: as many as where no scene says how many
  int resolution = 0;      ///< voxels along the longest side of the global volume; 0: it needs none
  bool apertures = false;  ///< reads the apertures of scenes that have them; others are lit as if there were none
  ApertureMode apertureMode = ApertureMode::accurate;
  float constant = 0.5f;  ///< of Technique::constant
  bool prefilter = true;  ///< taps read the pyramid
  bool storable = false;  ///< a scene's lighting can say it: neither techniques nor aperture modes are in the format
};

/// How much of the sweep is taken.
enum class SweepSize { variant, quick, full };

/// The settings for a scene with the lighting `own`, with or without apertures, none twice: its own first, by the name of what lights it
/// (usedEstimator), our estimators by resolution, taps and cones, then every other technique. `quick` leaves many of them out; `variant`,
/// for a further bake of a scene, all but the few that tell how good its occluders are.
std::vector<SweepSetting> sweepSettings(const Lighting& own, bool apertures, SweepSize size);

/// What `size` leaves out of the sweep, in words; empty: nothing.
std::string leftOutOf(SweepSize size);

/// What the scene would say with this setting: `own` but for estimator, taps, cones and resolution. Constants stay as the scene has them;
/// those of another estimator than the scene's are the program's own (withName).
Lighting lightingWith(const Lighting& own, const SweepSetting& setting);

const char* nameOf(ApertureMode mode);

/// What makes a renderer follow it, beside the lighting of lightingWith.
FrameSettings frameSettings(const SweepSetting& setting, int width, int height);

/// Rays through the volume at this resolution: the nearest to the truth that can be had of it.
SweepSetting raysSetting(int resolution);

}  // namespace overcast
