// OBJ. OpenMesh 9 reads the faces, with all the ways OBJ has of naming a corner. It keeps single floats only, drops a vertex it cannot
// read (which shifts every later index), ignores faces on continued lines and opens material files; so it is given the vertex and
// face lines alone, continued lines joined, every vertex at zero, and the coordinates are taken from our own scan in double.
#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
#include <OpenMesh/Core/IO/reader/OBJReader.hh>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "formats/mesh_reader.h"
#include "formats/mesh_text.h"

namespace overcast {
namespace {

/// Takes vertices and faces from an OpenMesh reader as they come. A half-edge mesh would refuse the faces that are not manifold.
class RawImporter final : public OpenMesh::IO::BaseImporter {
 public:
  explicit RawImporter(RawMesh& mesh) : mesh_(mesh) {}

  OpenMesh::VertexHandle add_vertex(const OpenMesh::Vec3f&) override { return add_vertex(); }
  OpenMesh::VertexHandle add_vertex() override { return OpenMesh::VertexHandle(static_cast<int>(vertices_++)); }
  OpenMesh::FaceHandle add_face(const VHandles& handles) override {
    for (const OpenMesh::VertexHandle handle : handles) mesh_.corners.push_back(toCorner(handle.idx()));
    endFace(mesh_);
    return OpenMesh::FaceHandle(static_cast<int>(mesh_.faceEnds.size()) - 1);
  }
  size_t n_vertices() const override { return vertices_; }
  size_t n_faces() const override { return mesh_.faceEnds.size(); }
  size_t n_edges() const override { return 0; }

  // Attributes and half-edges, which the occluders do not need.
  OpenMesh::HalfedgeHandle add_edge(OpenMesh::VertexHandle, OpenMesh::VertexHandle) override { return OpenMesh::HalfedgeHandle(); }
  OpenMesh::FaceHandle add_face(OpenMesh::HalfedgeHandle) override { return OpenMesh::FaceHandle(); }
  void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle, const std::vector<OpenMesh::Vec2f>&) override {}
  void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle, const std::vector<OpenMesh::Vec3f>&) override {}
  void set_face_texindex(OpenMesh::FaceHandle, int) override {}
  void set_point(OpenMesh::VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_halfedge(OpenMesh::VertexHandle, OpenMesh::HalfedgeHandle) override {}
  void set_normal(OpenMesh::VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_normal(OpenMesh::VertexHandle, const OpenMesh::Vec3d&) override {}
  void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec4f&) override {}
  void set_texcoord(OpenMesh::VertexHandle, const OpenMesh::Vec2f&) override {}
  void set_status(OpenMesh::VertexHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_next(OpenMesh::HalfedgeHandle, OpenMesh::HalfedgeHandle) override {}
  void set_face(OpenMesh::HalfedgeHandle, OpenMesh::FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void set_texcoord(OpenMesh::HalfedgeHandle, const OpenMesh::Vec2f&) override {}
  void set_texcoord(OpenMesh::VertexHandle, const OpenMesh::Vec3f&) override {}
  void set_texcoord(OpenMesh::HalfedgeHandle, const OpenMesh::Vec3f&) override {}
  void set_status(OpenMesh::HalfedgeHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec3f&) override {}
  void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec4f&) override {}
  void set_status(OpenMesh::EdgeHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void set_normal(OpenMesh::FaceHandle, const OpenMesh::Vec3f&) override {}
  void set_normal(OpenMesh::FaceHandle, const OpenMesh::Vec3d&) override {}
  void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec3uc&) override {}
  void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec4uc&) override {}
  void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec3f&) override {}
  void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec4f&) override {}
  void set_status(OpenMesh::FaceHandle, const OpenMesh::Attributes::StatusInfo&) override {}
  void add_texture_information(int, std::string) override {}

 private:
  RawMesh& mesh_;
  std::size_t vertices_ = 0;
};

/// A line of the file, with the lines that a backslash at its end continues it by.
struct LogicalLine {
  std::uint64_t number = 0;  ///< of its first line
  bool ended = true;         ///< by a line end, not by the end of the file
  std::string joined;        ///< storage for continued lines
  std::string_view text;
};

bool nextLine(TextScanner& scanner, LogicalLine& line) {
  if (scanner.rest.empty()) return false;
  line.number = scanner.line;
  line.joined.clear();
  for (;;) {
    const std::string_view before = scanner.rest;
    skipLine(scanner);
    line.text = before.substr(0, before.size() - scanner.rest.size());
    const std::size_t last = line.text.find_last_not_of("\r\n");
    line.ended = last + 1 < line.text.size();
    line.text = line.text.substr(0, last + 1);
    const bool continued = line.text.ends_with('\\') && line.ended && !scanner.rest.empty();
    if (!continued && line.joined.empty()) return true;
    line.joined.append(line.text, 0, line.text.size() - (continued ? 1 : 0)).push_back(' ');
    line.text = line.joined;
    if (!continued) return true;
  }
}

/// What OpenMesh is given, and how many faces it has been given.
struct FaceText {
  std::string text;
  std::uint64_t faces = 0;
  std::vector<glm::vec2> coordinates;  ///< of the file's texture; not finite where they cannot be read
  std::vector<MappedCorner> corners;   ///< of all faces
  std::vector<std::uint64_t> faceEnds;
};

/// The place that an index of OBJ names, 1 for the first of `count` so far or -1 for the last one.
std::uint32_t placeOf(std::int64_t index, std::size_t count) {
  return toCorner(index < 0 ? static_cast<std::int64_t>(count) + index : index - 1);
}

/// u and v of a texture coordinate, v upwards; one that is not a number is of no use, but no reason to refuse the mesh.
void addCoordinate(TextScanner words, FaceText& out) {
  const std::optional<double> u = toDouble(nextWordOnLine(words));
  const std::string_view second = nextWordOnLine(words);
  const std::optional<double> v = second.empty() ? 0.0 : toDouble(second);
  constexpr double kNone = std::numeric_limits<double>::infinity();
  out.coordinates.emplace_back(u.value_or(kNone), 1.0 - v.value_or(kNone));
}

/// The corner that a word like 3, 3/7, 3//9 or 3/7/9 names.
MappedCorner cornerOf(std::string_view word, std::int64_t vertex, std::size_t vertices, std::size_t coordinates) {
  MappedCorner corner{placeOf(vertex, vertices), kBadIndex};
  const std::size_t slash = word.find('/');
  if (slash == std::string_view::npos) return corner;
  const std::string_view rest = word.substr(slash + 1);
  if (const auto index = toInteger(rest.substr(0, rest.find('/')))) corner.coordinate = placeOf(*index, coordinates);
  return corner;
}

Result<Done> addVertex(TextScanner words, const LogicalLine& line, RawMesh& mesh) {
  const std::string place = fmt::format("line {}", line.number);
  glm::dvec3 position;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = nextWordOnLine(words);
    if (word.empty()) {
      return Error{"", place, line.ended ? "a vertex has fewer than three coordinates" : "is cut short: ends in the middle of a vertex"};
    }
    const std::optional<double> value = toDouble(word);
    if (!value) return Error{"", place, fmt::format("'{}' is not a coordinate", shown(word))};
    position[axis] = *value;
  }
  mesh.positions.push_back(position);
  return Done{};
}

/// Passes a face on to OpenMesh without the texture and normal indices, which name lines that it is not given, and keeps the former. An
/// index that an int cannot hold becomes 0, which names no vertex: OpenMesh would misread it.
Result<Done> addFace(TextScanner words, const LogicalLine& line, std::size_t vertices, FaceText& out) {
  const std::string place = fmt::format("line {}", line.number);
  out.text += 'f';
  int corners = 0;
  for (std::string_view word = nextWordOnLine(words); !word.empty(); word = nextWordOnLine(words), ++corners) {
    const std::optional<std::int64_t> index = toInteger(word.substr(0, word.find('/')));
    if (!index) return Error{"", place, fmt::format("'{}' is not a corner of a face", shown(word))};
    fmt::format_to(std::back_inserter(out.text), " {}", std::abs(*index) < kBadIndex / 2 ? *index : 0);
    if (!out.coordinates.empty()) out.corners.push_back(cornerOf(word, *index, vertices, out.coordinates.size()));
  }
  out.text += '\n';
  ++out.faces;
  out.faceEnds.push_back(out.corners.size());
  if (corners < 3 && !line.ended) {
    return Error{"", place, "is cut short: ends in the middle of a face"};
  }
  return Done{};
}

Result<FaceText> scan(std::string_view text, RawMesh& mesh) {
  FaceText out;
  TextScanner scanner{text, 1, '\0'};
  LogicalLine line;
  while (nextLine(scanner, line)) {
    TextScanner words{line.text, 1, '#'};
    const std::string_view keyword = nextWordOnLine(words);
    Result<Done> added = Done{};
    if (keyword == "v") {
      added = addVertex(words, line, mesh);
      out.text += "v 0 0 0\n";
    } else if (keyword == "f" || keyword == "fo") {
      added = addFace(words, line, mesh.positions.size(), out);
    } else if (keyword == "vt") {
      addCoordinate(words, out);
    }
    if (!added) return added.error();
  }
  return out;
}

}  // namespace

Result<RawMesh> parseObj(std::string_view text) {
  RawMesh mesh;
  Result<FaceText> scanned = scan(text, mesh);
  if (!scanned) return scanned.error();
  FaceText faces = std::move(scanned).value();
  OpenMesh::IO::OBJReader();  // the reader registers itself when it is first asked for
  RawImporter importer(mesh);
  OpenMesh::IO::Options options;
  std::istringstream stream(std::move(faces.text));
  const bool understood = OpenMesh::IO::IOManager().read(stream, ".obj", importer, options);
  if (!understood || importer.n_vertices() != mesh.positions.size()) return Error{"", "", "OpenMesh does not understand its faces"};
  // OpenMesh leaves out corners that repeat one of the same face, and then faces with fewer than three.
  const std::uint64_t given = mesh.faceEnds.size() + mesh.shortFaces;
  if (given > faces.faces) return Error{"", "", "OpenMesh finds more faces than the file has"};
  mesh.shortFaces += faces.faces - given;
  if (!faces.coordinates.empty()) mapCorners(mesh, faces.coordinates, faces.corners, faces.faceEnds);
  return mesh;
}

}  // namespace overcast
