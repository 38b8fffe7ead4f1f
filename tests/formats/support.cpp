#include "tests/formats/support.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "formats/result.h"

namespace overcast {

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "overcast-test-XXXXXX").string();
  OVERCAST_REQUIRE(::mkdtemp(pattern.data()) != nullptr, "cannot make the folder {}", pattern);
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::vector<std::byte> fileBytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  std::vector<std::byte> bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

void putBytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

std::vector<std::byte> mutated(std::vector<std::byte> bytes, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(engine() % n); };
  // Half of the accidents happen in the header, where they do most.
  const std::size_t reach = engine() % 2 == 0 ? std::min<std::size_t>(bytes.size(), 400) : bytes.size();
  const std::size_t at = below(reach);
  const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  const auto stretch = static_cast<std::ptrdiff_t>(below(std::min<std::size_t>(bytes.size() - at, 64)));
  switch (seed % 5) {
    case 0:
      for (int i = 0; i < 4; ++i) bytes[below(reach)] = static_cast<std::byte>(engine());
      break;
    case 1:
      bytes.erase(first, first + stretch);
      break;
    case 2:
      bytes.insert(first, stretch, std::byte{0x7f});
      break;
    case 3:
      for (std::size_t i = at; i < std::min(at + 4, bytes.size()); ++i) bytes[i] = std::byte{0xff};
      break;
    default:
      bytes.resize(at);
  }
  return bytes;
}

}  // namespace overcast
