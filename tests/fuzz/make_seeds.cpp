// overcast-make-seeds CORPUS: small valid files of binary, fixed-column and large JSON formats into CORPUS/<fuzzer>. Without them a fuzzer
// spends its time before magic numbers, checksums and compressed blocks.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/vec2.hpp>

#include "formats/aperture_map.h"
#include "formats/image.h"
#include "formats/image_mipmaps.h"
#include "formats/report.h"
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

/// A record of a USGS DEM: fields at their columns, filled up to whole blocks.
std::string usgsRecord(const std::vector<std::pair<std::size_t, std::string>>& fields) {
  std::string record(1024, ' ');
  for (const auto& [column, text] : fields) {
    if (column + text.size() > record.size()) record.resize((column + text.size() + 1023) / 1024 * 1024, ' ');
    std::copy(text.begin(), text.end(), record.begin() + static_cast<std::ptrdiff_t>(column));
  }
  return record;
}

/// Two profiles, the second with more heights than its first block holds.
std::string smallUsgs() {
  std::string text = usgsRecord({{150, "     1"}, {528, "     2     2"}, {816, "  3.0000D+01  3.0000D+01  1.0000D+00"}, {858, "     2"}});
  for (const int count : {3, 150}) {
    std::string heights;
    for (int i = 0; i < count; ++i) heights += fmt::format("{:6}", i % 5 == 4 ? -32767 : 100 + i);
    const std::string head = fmt::format("     1{:6}{:6}     1{:24}{:24}{:24}", count > 3 ? 2 : 1, count, count > 3 ? "530.0D0" : "500.0D0",
                                         "4000.0D0", "0.0D0");
    const std::size_t first = 6 * std::min<std::size_t>(static_cast<std::size_t>(count), 146);
    text += usgsRecord({{0, head}, {144, heights.substr(0, first)}, {1024, heights.substr(first)}}).substr(0, count > 146 ? 2048 : 1024);
  }
  return text;
}

bool writeText(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file.good()) std::fprintf(stderr, "overcast-make-seeds: %s: cannot be written\n", path.c_str());
  return file.good();
}

// Our own writer makes no grey PNG: the one here is 2 x 2 of 16 bits, its pixels stored and not packed.
bool writeTerrains(const fs::path& folder) {
  constexpr unsigned char kGrey[] = {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52,
                                     0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x10, 0x00, 0x00, 0x00, 0x00, 0x07, 0x4d, 0x8e,
                                     0xbb, 0x00, 0x00, 0x00, 0x15, 0x49, 0x44, 0x41, 0x54, 0x78, 0x01, 0x01, 0x0a, 0x00, 0xf5, 0xff,
                                     0x00, 0x00, 0x00, 0x4e, 0x20, 0x00, 0x9c, 0x40, 0xff, 0xff, 0x09, 0x19, 0x03, 0x49, 0xee, 0x82,
                                     0x68, 0x28, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  std::error_code code;
  fs::create_directories(folder, code);
  return reported(writeExr(folder / "heights.exr", smallImage(3, 2, {"Y"}), ExrBits::single)) &&
         writeText(folder / "heights.png", std::string(std::begin(kGrey), std::end(kGrey))) &&
         writeText(folder / "grid.asc", "ncols 3\nnrows 2\nxllcorner 5\nyllcorner 7\ncellsize 30\nNODATA_value -1\n1 2 3\n4 -1 6.5\n") &&
         writeText(folder / "degrees.asc", "ncols 2\nnrows 2\nxllcenter 10\nyllcenter 60\ndx 0.001\ndy 1e-3\n1 2 3 4\n") &&
         writeText(folder / "blocks.dem", smallUsgs());
}

/// One with every field, and one with as few as there may be.
bool writeReports(const fs::path& folder) {
  Report report{"a device", "CPU", "driver 1", "1.3", 64, 36, 640, 360, 7, 0.03, "much", {}};
  ReportRow row;
  row.setting = "hybrid, 4 taps, 128^3";
  row.technique = "overcast";
  row.estimator = "hybrid";
  row.resolution = 128;
  row.taps = row.cones = 4;
  row.apertureMode = "accurate";
  row.occluders = row.bake = "8 bits, up to 32 samples";
  row.storable = true;
  row.errors = {0.1, 0.09, -0.05, 0.07, 0.2, 0.3, 0.4, 0.9, 0.12, 0.01, {0.1, 0.2}};
  row.frame = row.still = {3.0, 3.5, 0.5, 6};
  row.passes = {{"composite", {2.0, 2.25, 0.5, 6}}};
  row.gpuBytes = std::uint64_t{1} << 40;
  row.steps = {{"estimator", 0.1, -0.05, 1.25}};
  report.scenes.push_back({"clutter", "abc", 2, 1000, 0.002, 7, {{"view0", 0, 0.0}, {"view0", 30, 1.0}}, {row}});
  std::error_code code;
  fs::create_directories(folder, code);
  return writeText(folder / "full.json", reportJson(report)) &&
         writeText(folder / "bare.json", reportJson({"a device", "", "", "", 1, 1, 1, 1, 1, 0.0, "", {}}));
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "Usage: %s CORPUS\n", arguments[0]);
    return 2;
  }
  const fs::path corpus = arguments[1];
  return writeVolumes(corpus / "vdb") && writeExrs(corpus / "exr") && writePngs(corpus / "png") &&
                 writeApertureMaps(corpus / "aperture_map") && writeTerrains(corpus / "terrain") && writeReports(corpus / "report")
             ? 0
             : 1;
}
