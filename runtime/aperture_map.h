// Aperture maps on the device (formats/aperture_map.h).
#pragma once

#include "formats/aperture_map.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// The levels of a map that are of use, and no more, so that sampling never reads a coarser one. In layout SHADER_READ_ONLY_OPTIMAL.
struct ApertureMapImages {
  GpuImage cap;      ///< RGBA16F: direction in the mesh's local space; radius in units of pi/2
  GpuImage ambient;  ///< R16F: cosine-weighted visibility
};

/// An Error when the device cannot hold it.
Result<ApertureMapImages> uploadApertureMap(const Device& device, const ApertureMap& map);
void destroyApertureMap(const Device& device, ApertureMapImages& images);

}  // namespace overcast
