#include <algorithm>

#include "formats/image_parse.h"
#include "formats/terrain_parse.h"

namespace overcast {

Result<Terrain> parseTerrainExr(std::span<const std::byte> bytes) {
  const auto read = parseExr(bytes, "");
  if (!read) return read.error();
  const Image& image = read.value();
  int channel = image.channels.size() == 1 ? 0 : -1;
  for (const char* name : {"height", "Y", "R"})
    if (channel < 0) channel = channelIndex(image, name);
  if (channel < 0) return Error{"", "channels", "none is named height, Y or R: this picture holds no heights"};
  if (const auto fits = checkTerrainSize(image.width, image.height); !fits) return fits.error();
  Terrain terrain;
  terrain.columns = image.width;
  terrain.rows = image.height;
  const std::size_t step = image.channels.size();
  for (auto i = static_cast<std::size_t>(channel); i < image.pixels.size(); i += step)
    terrain.heights.push_back(asHeight(double{image.pixels[i]}));
  return terrain;
}

}  // namespace overcast
