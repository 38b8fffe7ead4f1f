#include <cstddef>
#include <cstdint>
#include <span>

#include "formats/image_parse.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto parsed = overcast::parseExr(std::as_bytes(std::span(data, size)), "input");
  if (parsed && !overcast::isWhole(parsed.value())) __builtin_trap();
  const auto mipmaps = overcast::parseMipmaps(std::as_bytes(std::span(data, size)), "input");
  if (mipmaps && !overcast::isWhole(mipmaps.value())) __builtin_trap();
  return 0;
}
