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

/// Whether a file must survive the loss of power. One that need not is written without waiting for the disk: it may be torn after a power
/// failure, though not after a crash of the program.
enum class Durability { synced, unsynced };

/// Replaces `path` by `bytes` so that a reader, a crash or a full disk sees either the old file or the new one, never a torn one:
/// a file in the same folder without a name (where the file system knows no such: a temporary one), write, fsync, link or rename, fsync of
/// the folder. Creates missing folders. On failure the new file is gone and the old one untouched. Killing the program leaves no other file
/// behind, but in the moment in which a new file takes the place of an old one.
Result<Done> writeFileAtomically(const std::filesystem::path& path, std::span<const std::byte> bytes,
                                 Durability durability = Durability::synced);
Result<Done> writeFileAtomically(const std::filesystem::path& path, std::string_view text);

/// An Error that says why files cannot be written into `folder`, which need not exist yet; leaves nothing behind.
Result<Done> checkWritable(const std::filesystem::path& folder);

/// 128-bit hash (XXH3) of the bytes as 32 lower-case hexadecimal digits. Not cryptographic: it names content, it does not authenticate it.
std::string contentHash(std::span<const std::byte> bytes);

/// The contentHash of a file, of any size, in little memory; an Error as of readFile.
Result<std::string> fileHash(const std::filesystem::path& path);

/// `relative` (a URI path inside an asset, still percent-encoded) resolved against `folder`; an Error when it is absolute, has a scheme, or
/// leaves the folder (DESIGN, PITFALLS "Formats").
Result<std::filesystem::path> resolveInside(const std::filesystem::path& folder, std::string_view relative);

/// The file `relative` (a path, not percent-encoded) inside `folder`, when its contentHash is this; an Error otherwise, and as those above.
Result<std::filesystem::path> checkedFile(const std::filesystem::path& folder, std::string_view relative, const std::string& hash);

}  // namespace overcast
