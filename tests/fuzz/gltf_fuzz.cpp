// Fuzzes the glTF reader without its sandbox: crashes and hangs that the sandbox would hide show here.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "formats/gltf_reader.h"
#include "formats/scene_check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path folder = [] {
    std::string name = (std::filesystem::temp_directory_path() / "overcast-fuzz-XXXXXX").string();
    return std::filesystem::path(::mkdtemp(name.data()));
  }();
  const auto path = folder / "scene.gltf";
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  auto scene = overcast::readGltfScene(path);
  if (scene && !overcast::brokenInvariant(scene.value()).empty()) std::abort();
  return 0;
}
