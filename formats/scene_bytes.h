// A Scene as bytes, to cross from the sandbox to its parent. Internal to formats; never on disk, so it has no version.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "formats/scene.h"

namespace overcast {

std::vector<std::byte> packScene(const Scene& scene);

/// The scene that was packed; nothing when the bytes are cut short, too long, or hold a scene that breaks its invariants
/// (formats/scene_check.h): a parser that went astray before it answered must not harm its parent.
std::optional<Scene> unpackScene(std::span<const std::byte> bytes);

}  // namespace overcast
