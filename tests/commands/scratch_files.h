// Scratch files: what the tests of commands ask of the files in a folder.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

namespace overcast::test {

inline std::string contents(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Path below `folder` and content of every file in it, but for the cache that --each keeps there.
inline std::map<std::string, std::string> everythingIn(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  if (!std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string path = entry.path().lexically_relative(folder).string();
    if (entry.is_regular_file() && !path.starts_with(".overcast-cache")) files[path] = contents(entry.path());
  }
  return files;
}

}  // namespace overcast::test
