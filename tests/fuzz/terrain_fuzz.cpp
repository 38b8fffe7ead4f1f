#include <cstddef>
#include <cstdint>
#include <new>
#include <span>

#include "formats/terrain.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto parsed = overcast::parseTerrain(std::as_bytes(std::span(data, size)), "input", {});
    if (parsed && !overcast::isWhole(parsed.value())) __builtin_trap();
  } catch (const std::bad_alloc&) {
    return 0;  // OpenEXR may throw it; the sandbox makes it an Error
  }
  return 0;
}
