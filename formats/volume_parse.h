// What readVolume runs inside the sandbox. Internal to formats and its fuzzer.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "formats/volume.h"

namespace overcast {

/// The bytes of the .vdb `file` as a volume; errors as in readVolume. Throws std::bad_alloc.
Result<Volume> parseVolume(std::span<const std::byte> bytes, const std::string& file);

}  // namespace overcast
