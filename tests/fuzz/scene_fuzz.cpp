// Fuzzes the glTF reader as it runs inside the sandbox: text when the input starts with a brace, GLB otherwise.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "formats/gltf_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("overcast-fuzz-scene-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::filesystem::path file = folder / (data[0] == '{' ? "input.gltf" : "input.glb");
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  (void)overcast::readGltfScene(file);
  return 0;
}
