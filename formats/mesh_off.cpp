// OFF, ASCII and binary (Geomview 1.9, "OFF Files"). Our own reader: OpenMesh 9 keeps single floats only, takes cut files for whole,
// refuses comments before the keyword, and hangs on damaged ones.
#include <array>
#include <bit>
#include <cstring>
#include <optional>

#include "formats/mesh_reader.h"
#include "formats/mesh_text.h"

namespace overcast {
namespace {

struct OffHeader {
  bool texture = false;
  bool colour = false;
  bool normal = false;
  bool binary = false;
};

bool removePrefix(std::string_view& word, std::string_view prefix) {
  if (!word.starts_with(prefix)) return false;
  word.remove_prefix(prefix.size());
  return true;
}

/// Reads [ST][C][N]OFF and leaves the scanner behind it; the keyword is optional and may touch the first count ("OFF8 6 12").
Result<OffHeader> readHeader(TextScanner& scanner) {
  OffHeader header;
  TextScanner ahead = scanner;
  std::string_view word = nextWord(ahead);
  if (word.empty()) return Error{"", "", "is empty"};
  if (toInteger(word)) return header;
  header.texture = removePrefix(word, "ST");
  header.colour = removePrefix(word, "C");
  header.normal = removePrefix(word, "N");
  if (word.starts_with("4") || word.starts_with("n")) return Error{"", placeOf(ahead), "OFF of other than three dimensions is not read"};
  if (!removePrefix(word, "OFF")) return Error{"", placeOf(ahead), "is not an OFF file"};
  scanner = ahead;
  scanner.rest = std::string_view(word.data(), static_cast<std::size_t>(ahead.rest.data() + ahead.rest.size() - word.data()));
  TextScanner mode = scanner;
  if (nextWordOnLine(mode) == "BINARY") {
    // Exactly one line end: what follows may begin with bytes that look like blanks.
    skipLine(mode);
    scanner = mode;
    header.binary = true;
  }
  return header;
}

Result<std::int64_t> readCount(TextScanner& scanner, const char* what, std::size_t bytesEach) {
  const std::string_view word = nextWord(scanner);
  const std::optional<std::int64_t> count = toInteger(word);
  if (!count || *count < 0) return Error{"", placeOf(scanner), fmt::format("the number of {} is '{}'", what, shown(word))};
  if (static_cast<std::uint64_t>(*count) > scanner.rest.size() / bytesEach + 1) {
    return Error{"", placeOf(scanner), fmt::format("declares {} {}, but only {} bytes follow", *count, what, scanner.rest.size())};
  }
  return *count;
}

Error cutShort(const TextScanner& scanner, std::uint64_t have, std::int64_t want, const char* what) {
  return Error{"", placeOf(scanner), fmt::format("is cut short: ends after {} of {} {}", have, want, what)};
}

Result<Done> readVertices(TextScanner& scanner, std::int64_t count, RawMesh& mesh) {
  mesh.positions.reserve(static_cast<std::size_t>(count));
  for (std::int64_t v = 0; v < count; ++v) {
    glm::dvec3 position;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = nextWord(scanner);
      if (word.empty()) return cutShort(scanner, mesh.positions.size(), count, "vertices");
      const std::optional<double> value = toDouble(word);
      if (!value) return Error{"", placeOf(scanner), fmt::format("'{}' is not a coordinate", shown(word))};
      position[axis] = *value;
    }
    mesh.positions.push_back(position);
    skipLine(scanner);  // normals, colours, texture coordinates
  }
  return Done{};
}

Result<Done> readFaces(TextScanner& scanner, std::int64_t count, RawMesh& mesh) {
  for (std::int64_t f = 0; f < count; ++f) {
    const std::string_view first = nextWord(scanner);
    if (first.empty()) return cutShort(scanner, static_cast<std::uint64_t>(f), count, "faces");
    const std::optional<std::int64_t> corners = toInteger(first);
    if (!corners || *corners < 0) return Error{"", placeOf(scanner), fmt::format("'{}' is not a number of corners", shown(first))};
    for (std::int64_t c = 0; c < *corners; ++c) {
      const std::string_view word = nextWord(scanner);
      if (word.empty()) return cutShort(scanner, static_cast<std::uint64_t>(f), count, "faces");
      const std::optional<std::int64_t> index = toInteger(word);
      if (!index) return Error{"", placeOf(scanner), fmt::format("'{}' is not a vertex index", shown(word))};
      mesh.corners.push_back(toCorner(*index));
    }
    endFace(mesh);
    skipLine(scanner);  // colours
  }
  return Done{};
}

Result<RawMesh> readAscii(TextScanner scanner) {
  RawMesh mesh;
  const Result<std::int64_t> vertices = readCount(scanner, "vertices", 6);  // "0 0 0\n"
  if (!vertices) return vertices.error();
  const Result<std::int64_t> faces = readCount(scanner, "faces", 2);
  if (!faces) return faces.error();
  skipLine(scanner);  // the number of edges, which nobody counts
  const Result<Done> verticesRead = readVertices(scanner, vertices.value(), mesh);
  if (!verticesRead) return verticesRead.error();
  const Result<Done> facesRead = readFaces(scanner, faces.value(), mesh);
  if (!facesRead) return facesRead.error();
  return mesh;
}

/// How writers differ: Geomview says big endian with a count of colour components after each face; pmp-library and OpenMesh write the
/// machine's own order, pmp-library without that count.
struct BinaryLayout {
  std::endian order;
  bool colourCount;
};

struct BinaryScanner {
  std::string_view rest;
  std::endian order;

  std::optional<std::uint32_t> next() {
    if (rest.size() < 4) return std::nullopt;
    std::array<unsigned char, 4> b{};
    std::memcpy(b.data(), rest.data(), 4);
    rest.remove_prefix(4);
    if (order == std::endian::little) std::swap(b[0], b[3]), std::swap(b[1], b[2]);
    return std::uint32_t{b[0]} << 24 | std::uint32_t{b[1]} << 16 | std::uint32_t{b[2]} << 8 | b[3];
  }
};

/// The mesh if the bytes are exactly one in this layout.
std::optional<RawMesh> tryBinary(std::string_view bytes, const OffHeader& header, const BinaryLayout& layout) {
  BinaryScanner scanner{bytes, layout.order};
  const auto vertices = scanner.next(), faces = scanner.next(), edges = scanner.next();
  const std::size_t stride = 12 + (header.normal ? 12u : 0u) + (header.colour ? 16u : 0u) + (header.texture ? 8u : 0u);
  if (!edges || *vertices > scanner.rest.size() / stride || *faces > scanner.rest.size() / 4) return std::nullopt;
  RawMesh mesh;
  mesh.positions.reserve(*vertices);
  for (std::uint32_t v = 0; v < *vertices; ++v) {
    BinaryScanner vertex{scanner.rest.substr(0, stride), layout.order};
    glm::dvec3 position;
    for (int axis = 0; axis < 3; ++axis) position[axis] = std::bit_cast<float>(*vertex.next());
    mesh.positions.push_back(position);
    scanner.rest.remove_prefix(stride);
  }
  for (std::uint32_t f = 0; f < *faces; ++f) {
    const auto corners = scanner.next();
    // A face of no corners is the colour count of another layout.
    if (!corners || *corners == 0 || *corners > scanner.rest.size() / 4) return std::nullopt;
    for (std::uint32_t c = 0; c < *corners; ++c) mesh.corners.push_back(*scanner.next());
    endFace(mesh);
    if (!layout.colourCount) continue;
    const auto components = scanner.next();
    if (!components || *components > 4 || scanner.rest.size() < 4u * *components) return std::nullopt;
    scanner.rest.remove_prefix(std::size_t{4} * *components);
  }
  if (!scanner.rest.empty()) return std::nullopt;
  return mesh;
}

Result<RawMesh> readBinary(std::string_view bytes, const OffHeader& header) {
  for (const std::endian order : {std::endian::big, std::endian::little}) {
    for (const bool colourCount : {true, false}) {
      std::optional<RawMesh> mesh = tryBinary(bytes, header, {order, colourCount});
      if (mesh) return std::move(*mesh);
    }
  }
  return Error{"", "", "is cut short or damaged: its binary data does not fit the counts it declares"};
}

}  // namespace

Result<RawMesh> parseOff(std::string_view text) {
  TextScanner scanner{text, 1, '#'};
  const Result<OffHeader> header = readHeader(scanner);
  if (!header) return header.error();
  return header.value().binary ? readBinary(scanner.rest, header.value()) : readAscii(scanner);
}

}  // namespace overcast
