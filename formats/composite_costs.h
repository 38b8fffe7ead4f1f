// Composite costs: what one evaluation of each kind of occluder takes in the composite of one device. `overcast-player cost` measures and
// writes them, `overcast-bake` reads them to weigh representations: they meet in this file alone. Schema:
// formats/schema/composite_costs.schema.json
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/asset.h"
#include "formats/result.h"

namespace overcast {

inline constexpr int kCompositeCostsVersion = 1;

/// Device time of one evaluation of one kind: nanoseconds, which are milliseconds per million evaluations.
struct CompositeCost {
  Representation representation = Representation::volume;
  std::string variant;  ///< of a primitive "cuboid" or "ellipsoid", of a heightfield "single" or "pair"; else empty
  int size = 0;         ///< samples along the longest side, or texels along a side; 0 for a primitive
  int bits = 0;         ///< of a volume on the device: 8 or 16; else 0
  double median = 0.0;  ///< over the runs
  double least = 0.0;
  double most = 0.0;
};

/// One measurement of all kinds on one device.
struct CompositeCosts {
  std::string device;  ///< name of the Vulkan device
  std::string kind;    ///< DeviceInfo::kind, for example "CPU"
  std::string driver;  ///< name and version
  int objects = 0;     ///< evaluated at every voxel
  int voxels = 0;      ///< along the side of the composited cube
  int runs = 0;        ///< timed, for each kind
  std::vector<CompositeCost> costs;
};

/// The costs that are built in: data/reports/composite_costs_lavapipe.json.
const CompositeCosts& defaultCompositeCosts();

/// Median nanoseconds of one evaluation of `asset`, a volume's values with `volumeBits`. Between measured sizes linear in the logarithm of
/// the size, beyond them that of the nearest. A device has no floats of 32 bits for volumes: they cost what 16 do.
double compositeCost(const CompositeCosts& costs, const Asset& asset, VolumeBits volumeBits = VolumeBits::automatic);

/// One JSON document that ends with a line break, and back. Reading gives an Error that names the field when one is missing, wrong or out
/// of range, a representation has no entry, or the version is a later one.
std::string compositeCostsJson(const CompositeCosts& costs);
Result<CompositeCosts> parseCompositeCosts(std::string_view json, const std::string& place);
Result<CompositeCosts> readCompositeCosts(const std::filesystem::path& path);

}  // namespace overcast
