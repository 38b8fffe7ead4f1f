// Files: bounded reading, atomic writing, content hashes. Every byte that Overcast puts on disk goes through here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/result.h"

namespace overcast {

/// The whole file, at most `maxBytes` of it; an Error that names the file when it is missing, unreadable, not a regular file, or larger.
Result<std::vector<std::byte>> readFile(const std::filesystem::path& path, std::uint64_t maxBytes = std::uint64_t{4} << 30);

/// Replaces `path` by `bytes` so that a reader, a crash or a full disk sees either the old file or the new one, never a torn one:
/// temporary file in the same folder, write, fsync, rename, fsync of the folder. Creates missing folders.
/// On failure the temporary file is gone and the old file untouched.
Result<Done> writeFileAtomically(const std::filesystem::path& path, std::span<const std::byte> bytes);
Result<Done> writeFileAtomically(const std::filesystem::path& path, std::string_view text);

/// 128-bit hash (XXH3) of the bytes as 32 lower-case hexadecimal digits. Not cryptographic: it names content, it does not authenticate it.
std::string contentHash(std::span<const std::byte> bytes);

/// `relative` (a URI path inside an asset, still percent-encoded) resolved against `folder`; an Error when it is absolute, has a scheme, or
/// leaves the folder (DESIGN, PITFALLS "Formats").
Result<std::filesystem::path> resolveInside(const std::filesystem::path& folder, std::string_view relative);

}  // namespace overcast
