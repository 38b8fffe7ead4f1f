#include "tests/formats/mesh_samples.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <numbers>

#include <fmt/format.h>

namespace overcast::test {
namespace {

/// Appends the bytes of a number in the given order; the tests run on little-endian machines.
template <class T>
void put(std::string& bytes, T value, ByteOrder order) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (order == ByteOrder::big) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string joined(const glm::dvec3& p) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", p.x, p.y, p.z);
}

}  // namespace

TriangleMesh torus(int around, int across, bool singles, double scale, const glm::dvec3& offset) {
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2.0 * std::numbers::pi * i / around, v = 2.0 * std::numbers::pi * j / across;
      const double ring = 1.0 + 0.25 * std::cos(v);
      glm::dvec3 p = glm::dvec3(ring * std::cos(u), ring * std::sin(u), 0.25 * std::sin(v)) * scale + offset;
      if (singles) p = glm::dvec3(glm::vec3(p));
      mesh.positions.push_back(p);
      const auto at = [&](int a, int b) { return static_cast<std::uint32_t>((a % around) * across + b % across); };
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return mesh;
}

std::string objText(const TriangleMesh& mesh) {
  std::string text = "# a comment\nmtllib none.mtl\no torus\n";
  for (const glm::dvec3& p : mesh.positions) text += fmt::format("v {}\n", joined(p));
  for (const glm::uvec3& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t.x + 1, t.y + 1, t.z + 1);
  return text;
}

std::string offText(const TriangleMesh& mesh) {
  std::string text = fmt::format("OFF\n# a comment\n{} {} 0\n", mesh.positions.size(), mesh.triangles.size());
  for (const glm::dvec3& p : mesh.positions) text += joined(p) + '\n';
  for (const glm::uvec3& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t.x, t.y, t.z);
  return text;
}

std::string offBinary(const TriangleMesh& mesh, ByteOrder order, bool colourCount) {
  std::string bytes = "OFF BINARY\n";
  put(bytes, static_cast<std::int32_t>(mesh.positions.size()), order);
  put(bytes, static_cast<std::int32_t>(mesh.triangles.size()), order);
  put(bytes, std::int32_t{0}, order);
  for (const glm::dvec3& p : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) put(bytes, static_cast<float>(p[axis]), order);
  }
  for (const glm::uvec3& t : mesh.triangles) {
    put(bytes, std::int32_t{3}, order);
    for (int corner = 0; corner < 3; ++corner) put(bytes, t[corner], order);
    if (colourCount) put(bytes, std::int32_t{0}, order);
  }
  return bytes;
}

std::string plyText(const TriangleMesh& mesh) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\ncomment made by a test\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.positions.size(), mesh.triangles.size());
  for (const glm::dvec3& p : mesh.positions) text += joined(p) + '\n';
  for (const glm::uvec3& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t.x, t.y, t.z);
  return text;
}

std::string plyBinary(const TriangleMesh& mesh, ByteOrder order, bool doubles) {
  std::string bytes = fmt::format(
      "ply\nformat binary_{}_endian 1.0\nelement vertex {}\nproperty {} nx\nproperty {} x\nproperty {} y\nproperty {} z\n"
      "property list uchar short extra\nelement face {}\nproperty uchar flag\nproperty list int uint vertex_index\nend_header\n",
      order == ByteOrder::big ? "big" : "little", mesh.positions.size(), doubles ? "double" : "float", doubles ? "double" : "float",
      doubles ? "double" : "float", doubles ? "double" : "float", mesh.triangles.size());
  for (const glm::dvec3& p : mesh.positions) {
    for (const double value : {99.0, p.x, p.y, p.z}) doubles ? put(bytes, value, order) : put(bytes, static_cast<float>(value), order);
    put(bytes, std::uint8_t{2}, order);
    put(bytes, std::int16_t{-1}, order);
    put(bytes, std::int16_t{12345}, order);
  }
  for (const glm::uvec3& t : mesh.triangles) {
    put(bytes, std::uint8_t{7}, order);
    put(bytes, std::int32_t{3}, order);
    for (int corner = 0; corner < 3; ++corner) put(bytes, t[corner], order);
  }
  return bytes;
}

std::string stlText(const TriangleMesh& mesh) {
  std::string text = "solid torus with facet and vertex in its name\n";
  for (const glm::uvec3& t : mesh.triangles) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (int corner = 0; corner < 3; ++corner) text += fmt::format("   vertex {}\n", joined(mesh.positions[t[corner]]));
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid\n";
}

std::string stlBinary(const TriangleMesh& mesh) {
  std::string bytes = "solid in name only";
  bytes.resize(80, ' ');
  put(bytes, static_cast<std::uint32_t>(mesh.triangles.size()), ByteOrder::little);
  for (const glm::uvec3& t : mesh.triangles) {
    for (int axis = 0; axis < 3; ++axis) put(bytes, 0.0f, ByteOrder::little);
    for (int corner = 0; corner < 3; ++corner) {
      for (int axis = 0; axis < 3; ++axis) put(bytes, static_cast<float>(mesh.positions[t[corner]][axis]), ByteOrder::little);
    }
    put(bytes, std::uint16_t{0}, ByteOrder::little);
  }
  return bytes;
}

std::map<std::string, std::string> everyFormat(const TriangleMesh& mesh) {
  return {{"text.obj", objText(mesh)},
          {"text.off", offText(mesh)},
          {"big_colours.off", offBinary(mesh, ByteOrder::big, true)},
          {"big.off", offBinary(mesh, ByteOrder::big, false)},
          {"little_colours.off", offBinary(mesh, ByteOrder::little, true)},
          {"little.off", offBinary(mesh, ByteOrder::little, false)},
          {"text.ply", plyText(mesh)},
          {"little_float.ply", plyBinary(mesh, ByteOrder::little, false)},
          {"little_double.ply", plyBinary(mesh, ByteOrder::little, true)},
          {"big_float.ply", plyBinary(mesh, ByteOrder::big, false)},
          {"big_double.ply", plyBinary(mesh, ByteOrder::big, true)},
          {"text.stl", stlText(mesh)},
          {"binary.STL", stlBinary(mesh)}};
}

}  // namespace overcast::test
