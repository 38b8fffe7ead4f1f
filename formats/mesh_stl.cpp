// STL, ASCII and binary. Our own reader: OpenMesh 9 welds corners, drops facets, hangs a corner that is NaN on some other vertex and takes
// cut files for whole.
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <string>

#include "formats/mesh_reader.h"
#include "formats/mesh_text.h"

namespace overcast {
namespace {

constexpr std::size_t kBinaryHeader = 84;
constexpr std::size_t kBinaryFacet = 50;

std::uint32_t littleEndian32(const char* at) {
  std::array<unsigned char, 4> b{};
  std::memcpy(b.data(), at, 4);
  return std::uint32_t{b[3]} << 24 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[1]} << 8 | b[0];
}

void addCorner(const glm::dvec3& position, RawMesh& mesh) {
  mesh.corners.push_back(toCorner(static_cast<std::int64_t>(mesh.positions.size())));
  mesh.positions.push_back(position);
}

RawMesh readBinary(std::string_view bytes, std::uint32_t facets) {
  RawMesh mesh;
  mesh.positions.reserve(std::size_t{3} * facets);
  mesh.corners.reserve(std::size_t{3} * facets);
  mesh.faceEnds.reserve(facets);
  for (std::uint32_t f = 0; f < facets; ++f) {
    const char* at = bytes.data() + kBinaryHeader + std::size_t{f} * kBinaryFacet + 12;  // behind the normal
    for (int corner = 0; corner < 3; ++corner) {
      glm::dvec3 position;
      for (int axis = 0; axis < 3; ++axis, at += 4) position[axis] = std::bit_cast<float>(littleEndian32(at));
      addCorner(position, mesh);
    }
    endFace(mesh);
  }
  return mesh;
}

std::string lowered(std::string_view word) {
  std::string text(word.substr(0, 16));
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// "facet" or "endsolid" soon after "solid": binary headers begin with "solid" too.
bool looksLikeText(std::string_view bytes) {
  TextScanner scanner{bytes.substr(0, 4096), 1, '\0'};
  if (lowered(nextWord(scanner)) != "solid") return false;
  skipLine(scanner);
  const std::string next = lowered(nextWord(scanner));
  return next == "facet" || next == "endsolid";
}

Result<Done> readCorner(TextScanner& scanner, RawMesh& mesh) {
  glm::dvec3 position;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = nextWord(scanner);
    const std::optional<double> value = toDouble(word);
    if (!value && !word.empty()) return Error{"", placeOf(scanner), fmt::format("'{}' is not a coordinate", shown(word))};
    if (!value) return Error{"", placeOf(scanner), "is cut short: ends in the middle of a vertex"};
    position[axis] = *value;
  }
  addCorner(position, mesh);
  return Done{};
}

/// The facets of all solids, one after another.
Result<RawMesh> readText(std::string_view text) {
  RawMesh mesh;
  TextScanner scanner{text, 1, '\0'};
  bool inSolid = false;
  bool inFacet = false;
  for (std::string word = lowered(nextWord(scanner)); !word.empty(); word = lowered(nextWord(scanner))) {
    if (word == "vertex" && inFacet) {
      const Result<Done> read = readCorner(scanner, mesh);
      if (!read) return read.error();
    } else if ((word == "solid" && !inSolid) || (word == "endsolid" && inSolid && !inFacet)) {
      inSolid = word == "solid";
      skipLine(scanner);  // its name
    } else if (word == "facet" && inSolid && !inFacet) {
      inFacet = true;
      skipLine(scanner);  // its normal, which the corners give better
    } else if (word == "endfacet" && inFacet) {
      inFacet = false;
      endFace(mesh);
    } else if (word != "outer" && word != "loop" && word != "endloop") {
      return Error{"", placeOf(scanner), fmt::format("'{}' is out of place in an ASCII STL file", shown(word))};
    }
  }
  if (inSolid) return Error{"", placeOf(scanner), fmt::format("is cut short: ends after {} facets without endsolid", mesh.faceEnds.size())};
  return mesh;
}

}  // namespace

Result<RawMesh> parseStl(std::string_view text) {
  if (text.empty()) return Error{"", "", "is empty"};
  const bool hasBinaryHeader = text.size() >= kBinaryHeader;
  const std::uint32_t facets = hasBinaryHeader ? littleEndian32(text.data() + 80) : 0;
  const std::uint64_t needed = kBinaryHeader + std::uint64_t{facets} * kBinaryFacet;
  if (hasBinaryHeader && needed == text.size()) return readBinary(text, facets);
  if (looksLikeText(text)) return readText(text);
  if (!hasBinaryHeader) return Error{"", "", "is not an STL file"};
  if (needed > text.size()) {
    return Error{"", "", fmt::format("is cut short: ends after {} of {} facets", (text.size() - kBinaryHeader) / kBinaryFacet, facets)};
  }
  return readBinary(text, facets);
}

}  // namespace overcast
