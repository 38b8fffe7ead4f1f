// What the tests of file formats share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace overcast {

/// A folder of its own that goes away with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

std::vector<std::byte> fileBytes(const std::filesystem::path& path);
void putBytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes);

/// The bytes with one seeded accident: a few bytes changed, a stretch left out or repeated, a number made huge, or the end cut off.
std::vector<std::byte> mutated(std::vector<std::byte> bytes, std::uint64_t seed);

}  // namespace overcast
