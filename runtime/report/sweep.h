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
  int taps = 0;            ///< of Technique::overcast
  int resolution = 0;      ///< voxels along the longest side of the global volume; 0: it needs none
  bool apertures = false;  ///< reads the apertures of scenes that have them; others are lit as if there were none
  ApertureMode apertureMode = ApertureMode::accurate;
  float constant = 0.5f;  ///< of Technique::constant
  bool storable = false;  ///< a scene's lighting can say it: neither techniques nor aperture modes are in the format
};

/// The settings for a scene with the lighting `own`, with or without apertures, its own setting first: our estimators by resolution and
/// taps, then every other technique. `quick` leaves most of them out.
std::vector<SweepSetting> sweepSettings(const Lighting& own, bool apertures, bool quick);

/// What the scene would say with this setting: `own` but for estimator, taps and resolution. Constants stay as the scene has them; those of
/// another estimator than the scene's are the program's own.
Lighting lightingWith(const Lighting& own, const SweepSetting& setting);

const char* nameOf(ApertureMode mode);

/// What makes a renderer follow it, beside the lighting of lightingWith.
FrameSettings frameSettings(const SweepSetting& setting, int width, int height);

/// Rays through the volume at this resolution: the nearest to the truth that can be had of it.
SweepSetting raysSetting(int resolution);

}  // namespace overcast
