// overcast-make-seeds CORPUS: small valid files of the binary formats into CORPUS/<fuzzer>. Without them a fuzzer spends its time before
// magic numbers, checksums and compressed blocks.
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "formats/aperture_map.h"
#include "formats/image.h"
#include "formats/image_mipmaps.h"
#include "formats/volume.h"

namespace {

namespace fs = std::filesystem;
using namespace overcast;

Volume smallVolume(const glm::ivec3& size) {
  Volume volume;
  volume.size = size;
  volume.origin = {-0.5, 0.25, 1.0};
  volume.voxelSize = 0.125;
  volume.signMethod = "signed-crossings";
  for (int i = 0; i < size.x * size.y * size.z; ++i) volume.distance.push_back(0.125f * static_cast<float>(i % 7 - 2));
  return volume;
}

Image smallImage(int width, int height, const std::vector<std::string>& channels) {
  Image image{width, height, channels, {}};
  const int values = width * height * static_cast<int>(channels.size());
  for (int i = 0; i < values; ++i) image.pixels.push_back(static_cast<float>(i % 11) / 10.0f);
  return image;
}

MipmappedImage smallMipmaps() {
  MipmappedImage image;
  for (const glm::ivec2& size : {glm::ivec2(8, 4), glm::ivec2(4, 2), glm::ivec2(2, 1), glm::ivec2(1, 1)})
    image.levels.push_back(smallImage(size.x, size.y, {"mean", "variance"}));
  image.numbers["scale"] = 2.5;
  return image;
}

// Prints the error, if there is one; true when there is none.
template <class T>
bool reported(const Result<T>& result) {
  if (!result.ok()) std::fprintf(stderr, "overcast-make-seeds: %s\n", message(result.error()).c_str());
  return result.ok();
}

bool writeVolumes(const fs::path& folder) {
  return reported(writeVolume(folder / "half.vdb", smallVolume({2, 3, 4}), VolumeBits::half)) &&
         reported(writeVolume(folder / "snorm8.vdb", smallVolume({3, 9, 2}), VolumeBits::snorm8)) &&
         reported(writeVolume(folder / "single.vdb", smallVolume({9, 2, 2}), VolumeBits::single));
}

bool writeExrs(const fs::path& folder) {
  return reported(writeExr(folder / "half.exr", smallImage(3, 2, {"B", "G", "R"}), ExrBits::half)) &&
         reported(writeExr(folder / "single.exr", smallImage(2, 17, {"sky"}), ExrBits::single)) &&
         reported(writeMipmaps(folder / "mipmaps.exr", smallMipmaps()));
}

bool writeApertureMaps(const fs::path& folder) {
  ApertureMap map{{6, 4}, {{}}, 2};
  for (int i = 0; i < 24; ++i)
    map.levels[0].push_back({{{0.6f, 0.0f, 0.8f}, 0.06f * static_cast<float>(i)}, 0.5f, i % 5 == 0 ? 0.0f : 1.0f});
  buildLevels(map);
  return reported(writeApertureMap(folder / "map.exr", map));
}

bool writePngs(const fs::path& folder) {
  return reported(writePng(folder / "rgb.png", smallImage(3, 2, {"R", "G", "B"}))) &&
         reported(writePng(folder / "rgba.png", smallImage(5, 1, {"R", "G", "B", "A"})));
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "Usage: %s CORPUS\n", arguments[0]);
    return 2;
  }
  const fs::path corpus = arguments[1];
  return writeVolumes(corpus / "vdb") && writeExrs(corpus / "exr") && writePngs(corpus / "png") &&
                 writeApertureMaps(corpus / "aperture_map")
             ? 0
             : 1;
}
