// PLY, ASCII and both binary orders (Turk 1994, "The PLY Polygon File Format"), with triangle strips as the Stanford scans have them. Our
// own reader: OpenMesh 9 keeps single floats only, knows no strips, and crashes or hangs on damaged files.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "formats/mesh_reader.h"
#include "formats/mesh_text.h"

namespace overcast {
namespace {

enum class Type { none, int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  Type type = Type::none;
  Type countType = Type::none;  ///< none: a single value, not a list
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { ascii, little, big };

struct PlyHeader {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
};

Type typeNamed(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, Type>, 16> kNames{{{"char", Type::int8},
                                                                      {"int8", Type::int8},
                                                                      {"uchar", Type::uint8},
                                                                      {"uint8", Type::uint8},
                                                                      {"short", Type::int16},
                                                                      {"int16", Type::int16},
                                                                      {"ushort", Type::uint16},
                                                                      {"uint16", Type::uint16},
                                                                      {"int", Type::int32},
                                                                      {"int32", Type::int32},
                                                                      {"uint", Type::uint32},
                                                                      {"uint32", Type::uint32},
                                                                      {"float", Type::float32},
                                                                      {"float32", Type::float32},
                                                                      {"double", Type::float64},
                                                                      {"float64", Type::float64}}};
  for (const auto& [known, type] : kNames) {
    if (known == name) return type;
  }
  return Type::none;
}

std::size_t sizeOf(Type type) {
  switch (type) {
    case Type::none:
      return 0;
    case Type::int8:
    case Type::uint8:
      return 1;
    case Type::int16:
    case Type::uint16:
      return 2;
    case Type::int32:
    case Type::uint32:
    case Type::float32:
      return 4;
    case Type::float64:
      return 8;
  }
  return 0;
}

Result<Property> readProperty(TextScanner& scanner) {
  Property property;
  std::string_view word = nextWordOnLine(scanner);
  if (word == "list") {
    property.countType = typeNamed(nextWordOnLine(scanner));
    word = nextWordOnLine(scanner);
    if (property.countType == Type::none || property.countType >= Type::float32) {
      return Error{"", placeOf(scanner), "a list whose length is of no integer type"};
    }
  }
  property.type = typeNamed(word);
  if (property.type == Type::none) return Error{"", placeOf(scanner), fmt::format("'{}' is not a type of PLY", shown(word))};
  property.name = nextWordOnLine(scanner);
  return property;
}

Result<Encoding> readEncoding(TextScanner& scanner) {
  const std::string_view word = nextWordOnLine(scanner);
  if (word == "ascii") return Encoding::ascii;
  if (word == "binary_little_endian") return Encoding::little;
  if (word == "binary_big_endian") return Encoding::big;
  return Error{"", placeOf(scanner), fmt::format("unknown format '{}'", shown(word))};
}

/// Reads one header line behind its keyword.
Result<Done> readHeaderLine(std::string_view keyword, TextScanner& scanner, PlyHeader& header) {
  if (keyword == "format") {
    const Result<Encoding> encoding = readEncoding(scanner);
    if (!encoding) return encoding.error();
    header.encoding = encoding.value();
  } else if (keyword == "element") {
    const std::string_view name = nextWordOnLine(scanner);
    const std::string_view word = nextWordOnLine(scanner);
    const std::optional<std::int64_t> count = toInteger(word);
    if (!count || *count < 0) return Error{"", placeOf(scanner), fmt::format("'{}' is not a number of elements", shown(word))};
    header.elements.push_back({std::string(name), static_cast<std::uint64_t>(*count), {}});
  } else if (keyword == "property") {
    if (header.elements.empty()) return Error{"", placeOf(scanner), "a property before the first element"};
    Result<Property> property = readProperty(scanner);
    if (!property) return property.error();
    header.elements.back().properties.push_back(std::move(property).value());
  } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
    return Error{"", placeOf(scanner), fmt::format("'{}' is not a PLY header line", shown(keyword))};
  }
  return Done{};
}

Result<PlyHeader> readHeader(TextScanner& scanner) {
  // Lines end as the first one does: a binary body behind "end_header\r" may begin with \n, which is data then.
  const bool bareReturn = scanner.rest.size() > 4 && scanner.rest[3] == '\r' && scanner.rest[4] != '\n';
  if (nextWordOnLine(scanner) != "ply") return Error{"", "", scanner.rest.empty() ? "is empty" : "is not a PLY file"};
  skipLine(scanner);
  PlyHeader header;
  bool hasFormat = false;
  while (!scanner.rest.empty()) {
    const std::string_view keyword = nextWordOnLine(scanner);
    if (keyword == "end_header") {
      if (bareReturn && scanner.rest.starts_with('\r')) {
        scanner.rest.remove_prefix(1);
        ++scanner.line;
      } else {
        skipLine(scanner);
      }
      if (!hasFormat) return Error{"", "", "its header has no format line"};
      return header;
    }
    hasFormat = hasFormat || keyword == "format";
    const Result<Done> read = readHeaderLine(keyword, scanner, header);
    if (!read) return read.error();
    skipLine(scanner);
  }
  return Error{"", "", "is cut short: its header has no end_header"};
}

/// The values of the body, one after another.
struct Body {
  TextScanner scanner;
  Encoding encoding = Encoding::ascii;
  std::string problem;  ///< why next() failed, when not for the end of the file
};

/// The next value, or nothing when the file ends or holds no number there.
std::optional<double> nextValue(Body& body, Type type) {
  if (body.encoding == Encoding::ascii) {
    const std::string_view word = nextWord(body.scanner);
    const std::optional<double> value = toDouble(word);
    if (!value && !word.empty()) body.problem = fmt::format("'{}' is not a number", shown(word));
    return value;
  }
  const std::size_t size = sizeOf(type);
  if (body.scanner.rest.size() < size) return std::nullopt;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t at = body.encoding == Encoding::little ? size - 1 - i : i;
    bits = bits << 8 | static_cast<unsigned char>(body.scanner.rest[at]);
  }
  body.scanner.rest.remove_prefix(size);
  switch (type) {
    case Type::int8:
      return static_cast<std::int8_t>(bits);
    case Type::int16:
      return static_cast<std::int16_t>(bits);
    case Type::int32:
      return static_cast<std::int32_t>(bits);
    case Type::float32:
      return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    case Type::float64:
      return std::bit_cast<double>(bits);
    default:
      return static_cast<double>(bits);
  }
}

/// What a number says as a vertex index.
std::int64_t toIndex(double value) {
  return std::abs(value) < 9e15 && value == std::floor(value) ? static_cast<std::int64_t>(value) : std::int64_t{-1};
}

/// Reads one list; its values as indices into `list` when that is not null.
bool readList(Body& body, const Property& property, std::vector<std::int64_t>* list) {
  const std::optional<double> length = nextValue(body, property.countType);
  if (!length) return false;
  const std::int64_t count = toIndex(*length);
  if (count < 0) {
    body.problem = fmt::format("{} is not the length of a list", *length);
    return false;
  }
  for (std::int64_t i = 0; i < count; ++i) {
    const std::optional<double> value = nextValue(body, property.type);
    if (!value) return false;
    if (list != nullptr) list->push_back(toIndex(*value));
  }
  return true;
}

/// The triangles of a strip; -1 begins a new one. Triangles that repeat a corner only steer the strip and are left out.
void addStrip(const std::vector<std::int64_t>& strip, RawMesh& mesh) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < strip.size(); ++i) {
    if (strip[i] < 0) begin = i + 1;
    if (i < begin + 2 || strip[i] < 0) continue;
    const bool odd = (i - begin) % 2 == 1;
    const std::int64_t a = strip[i - 2], b = strip[odd ? i : i - 1], c = strip[odd ? i - 1 : i];
    if (a == b || b == c || c == a) continue;
    for (const std::int64_t index : {a, b, c}) mesh.corners.push_back(toCorner(index));
    endFace(mesh);
  }
}

enum class Role { vertices, faces, strips, other };

Role roleOf(const Element& element) {
  if (element.name == "vertex") return Role::vertices;
  if (element.name == "face") return Role::faces;
  if (element.name == "tristrips") return Role::strips;
  return Role::other;
}

bool holdsIndices(const Property& property) {
  return property.countType != Type::none && (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// Reads one element of any kind into the mesh. False when the file ends or is no number.
bool readElement(Body& body, const Element& element, Role role, std::vector<std::int64_t>& list, RawMesh& mesh) {
  glm::dvec3 position(0.0);
  list.clear();
  for (const Property& property : element.properties) {
    if (property.countType != Type::none) {
      const bool wanted = (role == Role::faces || role == Role::strips) && holdsIndices(property);
      if (!readList(body, property, wanted ? &list : nullptr)) return false;
      continue;
    }
    const std::optional<double> value = nextValue(body, property.type);
    if (!value) return false;
    const std::size_t axis = property.name.size() == 1 ? std::string_view("xyz").find(property.name[0]) : std::string_view::npos;
    if (axis != std::string_view::npos) position[static_cast<int>(axis)] = *value;
  }
  if (role == Role::vertices) mesh.positions.push_back(position);
  if (role == Role::strips) addStrip(list, mesh);
  if (role == Role::faces) {
    for (const std::int64_t index : list) mesh.corners.push_back(toCorner(index));
    endFace(mesh);
  }
  return true;
}

/// Fewest bytes that one element takes.
std::uint64_t smallest(const Element& element, Encoding encoding) {
  std::uint64_t bytes = 0;
  for (const Property& property : element.properties) {
    if (encoding == Encoding::ascii)
      bytes += 2;
    else
      bytes += sizeOf(property.countType == Type::none ? property.type : property.countType);
  }
  return bytes;
}

Result<Done> readElements(Body& body, const Element& element, RawMesh& mesh) {
  const Role role = roleOf(element);
  const std::uint64_t bytesEach = smallest(element, body.encoding);
  if (bytesEach == 0) return Done{};  // elements without properties leave no trace in the body
  const auto placeHere = [&] { return body.encoding == Encoding::ascii ? placeOf(body.scanner) : std::string(); };
  if (element.count > body.scanner.rest.size() / bytesEach + 1 && element.count > 0) {
    return Error{"", placeHere(),
                 fmt::format("is cut short: declares {} elements '{}', but only {} bytes follow", element.count, shown(element.name),
                             body.scanner.rest.size())};
  }
  if (role == Role::vertices) mesh.positions.reserve(element.count);
  std::vector<std::int64_t> list;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    if (readElement(body, element, role, list, mesh)) {
      // One line for each element; some writers put more on it than their header declares.
      if (body.encoding == Encoding::ascii) skipLine(body.scanner);
      continue;
    }
    if (!body.problem.empty()) return Error{"", placeHere(), body.problem};
    return Error{"", placeHere(), fmt::format("is cut short: ends after {} of {} elements '{}'", i, element.count, shown(element.name))};
  }
  return Done{};
}

/// A vertex needs x, y and z; a face its corners.
Result<Done> checkHeader(const PlyHeader& header) {
  for (const Element& element : header.elements) {
    const Role role = roleOf(element);
    const auto has = [&](std::string_view name) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& p) { return p.name == name && p.countType == Type::none; });
    };
    if (role == Role::vertices && !(has("x") && has("y") && has("z"))) return Error{"", "", "its vertices have no x, y and z"};
    if ((role == Role::faces || role == Role::strips) && std::none_of(element.properties.begin(), element.properties.end(), holdsIndices)) {
      return Error{"", "", fmt::format("its element '{}' has no vertex_indices", shown(element.name))};
    }
  }
  return Done{};
}

}  // namespace

Result<RawMesh> parsePly(std::string_view text) {
  Body body;
  body.scanner.rest = text;
  const Result<PlyHeader> header = readHeader(body.scanner);
  if (!header) return header.error();
  const Result<Done> checked = checkHeader(header.value());
  if (!checked) return checked.error();
  body.encoding = header.value().encoding;
  RawMesh mesh;
  for (const Element& element : header.value().elements) {
    const Result<Done> read = readElements(body, element, mesh);
    if (!read) return read.error();
  }
  return mesh;
}

}  // namespace overcast
