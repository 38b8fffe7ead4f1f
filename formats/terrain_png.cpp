#include <csetjmp>
#include <cstring>

#include <png.h>

#include "formats/image.h"
#include "formats/terrain_parse.h"

namespace overcast {
namespace {

/// Everything that libpng and we touch while it may leave by longjmp: nothing of it lives in the frames that are left.
struct Decoder {
  std::span<const std::byte> rest;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::string reason;
  std::vector<png_byte> row;
  Terrain terrain;

  Decoder() = default;
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
};

void takeBytes(png_structp png, png_bytep into, std::size_t count) {
  auto& decoder = *static_cast<Decoder*>(png_get_io_ptr(png));
  if (count > decoder.rest.size()) png_error(png, "the file is cut short");
  std::memcpy(into, decoder.rest.data(), count);
  decoder.rest = decoder.rest.subspan(count);
}

[[noreturn]] void fail(png_structp png, png_const_charp text) {
  static_cast<Decoder*>(png_get_error_ptr(png))->reason = text;
  png_longjmp(png, 1);
}

void ignore(png_structp, png_const_charp) {}

/// False, with a reason: the file is broken or no height map.
bool readHeader(Decoder& decoder) {
  if (setjmp(png_jmpbuf(decoder.png)) != 0) return false;
  png_read_info(decoder.png, decoder.info);
  const int bits = png_get_bit_depth(decoder.png, decoder.info);
  const int colour = png_get_color_type(decoder.png, decoder.info);
  const std::int64_t width = png_get_image_width(decoder.png, decoder.info), height = png_get_image_height(decoder.png, decoder.info);
  if (colour != PNG_COLOR_TYPE_GRAY && colour != PNG_COLOR_TYPE_GRAY_ALPHA)
    decoder.reason = "is a picture in colours: heights are read from grey PNG files of 16 bits";
  else if (bits != 16)
    decoder.reason = fmt::format("has {} bits: heights are read from grey PNG files of 16 bits, fewer would make terraces", bits);
  else if (const auto fits = checkTerrainSize(width, height); !fits)
    decoder.reason = fits.error().reason;
  if (!decoder.reason.empty()) return false;
  decoder.terrain.columns = static_cast<int>(width);
  decoder.terrain.rows = static_cast<int>(height);
  return true;
}

float heightIn(const png_byte* pixel, bool alpha) {
  if (alpha && pixel[2] == 0 && pixel[3] == 0) return kNoHeight;
  return static_cast<float>(pixel[0] * 256 + pixel[1]) / 65535.0f;
}

/// All rows; the vectors have their sizes already.
bool readRows(Decoder& decoder) {
  if (setjmp(png_jmpbuf(decoder.png)) != 0) return false;
  const bool alpha = png_get_channels(decoder.png, decoder.info) == 2;
  const auto columns = static_cast<std::size_t>(decoder.terrain.columns), rows = static_cast<std::size_t>(decoder.terrain.rows);
  const std::size_t step = alpha ? 4 : 2;
  const int passes = png_set_interlace_handling(decoder.png);
  png_read_update_info(decoder.png, decoder.info);
  // Interlaced files come in passes that each touch some pixels of a row: the whole picture is kept, otherwise one row.
  const std::size_t stride = passes > 1 ? columns * step : 0;
  for (int pass = 0; pass < passes; ++pass)
    for (std::size_t row = 0; row < rows; ++row) {
      png_byte* bytes = decoder.row.data() + row * stride;
      png_read_row(decoder.png, bytes, nullptr);
      for (std::size_t i = 0; i < columns && pass + 1 == passes; ++i)
        decoder.terrain.heights[row * columns + i] = heightIn(bytes + i * step, alpha);
    }
  png_read_end(decoder.png, nullptr);
  return true;
}

}  // namespace

Result<Terrain> parseTerrainPng(std::span<const std::byte> bytes) {
  Decoder decoder;
  decoder.rest = bytes;
  decoder.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &decoder, fail, ignore);
  if (decoder.png == nullptr) return Error{"", "", "libpng cannot be started"};
  decoder.info = png_create_info_struct(decoder.png);
  if (decoder.info == nullptr) return Error{"", "", "libpng cannot be started"};
  png_set_read_fn(decoder.png, &decoder, takeBytes);
  png_set_user_limits(decoder.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  const auto failure = [&] { return Error{"", "", fmt::format("not a readable height map ({})", decoder.reason)}; };
  if (!readHeader(decoder)) return failure();
  const Terrain& terrain = decoder.terrain;
  const std::size_t rows =
      png_get_interlace_type(decoder.png, decoder.info) == PNG_INTERLACE_NONE ? 1 : static_cast<std::size_t>(terrain.rows);
  decoder.row.resize(png_get_rowbytes(decoder.png, decoder.info) * rows);
  decoder.terrain.heights.assign(static_cast<std::size_t>(terrain.columns) * static_cast<std::size_t>(terrain.rows), kNoHeight);
  if (!readRows(decoder)) return failure();
  return std::move(decoder.terrain);
}

}  // namespace overcast
