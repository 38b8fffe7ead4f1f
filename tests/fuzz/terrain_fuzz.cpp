#include <cstddef>
#include <cstdint>
#include <span>

#include "formats/terrain.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto parsed = overcast::parseTerrain(std::as_bytes(std::span(data, size)), "input", {});
  if (parsed && !overcast::isWhole(parsed.value())) __builtin_trap();
  return 0;
}
