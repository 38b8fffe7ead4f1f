// The mesh readers without their sandbox. The first byte chooses the format, so that one corpus serves all four.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "formats/mesh_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace overcast;
  if (size == 0) return 0;
  constexpr Result<RawMesh> (*kParsers[])(std::string_view) = {parseObj, parseOff, parsePly, parseStl};
  Result<RawMesh> raw = kParsers[data[0] % 4](std::string_view(reinterpret_cast<const char*>(data) + 1, size - 1));
  if (!raw) return 0;
  const Result<MeshFile> file = finishMesh(std::move(raw).value());
  if (!file) return 0;
  for (const glm::uvec3& triangle : file.value().mesh.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      OVERCAST_REQUIRE(triangle[corner] < file.value().mesh.positions.size(), "index {} of {} vertices", triangle[corner],
                       file.value().mesh.positions.size());
    }
  }
  return 0;
}
