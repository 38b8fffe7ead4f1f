#include <cstddef>
#include <cstdint>
#include <new>
#include <span>

#include "formats/aperture_map.h"
#include "formats/image_parse.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto image = overcast::parseMipmaps(std::as_bytes(std::span(data, size)), "input");
    if (!image || !overcast::isWhole(image.value())) return 0;
    const auto map = overcast::apertureMapOf(image.value(), "input");
    if (map && !overcast::isWhole(map.value())) __builtin_trap();
  } catch (const std::bad_alloc&) {
    return 0;  // the parser may throw it; the sandbox makes it an Error
  }
  return 0;
}
