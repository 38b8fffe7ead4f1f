#include "formats/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "formats/files.h"
#include "tests/formats/mesh_samples.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;
using test::everyFormat;
using test::TemporaryFolder;
using test::torus;
using test::TriangleMesh;

/// Reads `bytes` as a file of this name.
Result<MeshFile> readAs(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  test::spill(folder.path / name, bytes);
  return readMesh(folder.path / name);
}

MeshFile mustRead(const std::string& name, const std::string& bytes) {
  auto file = readAs(name, bytes);
  OVERCAST_REQUIRE(file.ok(), "{}", message(file.error()));
  return std::move(file).value();
}

std::string errorOf(const std::string& name, const std::string& bytes) {
  const auto file = readAs(name, bytes);
  return file.ok() ? "(no error)" : file.error().place + "|" + file.error().reason;
}

/// `text` with every line end replaced by `lineEnd`.
std::string withLineEnds(const std::string& text, const char* lineEnd) {
  std::string result;
  for (const char c : text) {
    if (c == '\n') {
      result.append(lineEnd);
    } else if (c != '\r') {
      result.push_back(c);
    }
  }
  return result;
}

constexpr const char* kTwoTriangles = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Box, IsEmptyUntilSomethingIsIncluded) {
  Box box;
  EXPECT_TRUE(isEmpty(box));
  EXPECT_EQ(diagonal(box), 0.0);
  EXPECT_EQ(extent(box), glm::dvec3(0.0));
  include(box, Box{});
  EXPECT_TRUE(isEmpty(box));
  include(box, glm::dvec3(1, 2, 3));
  EXPECT_FALSE(isEmpty(box));
  EXPECT_EQ(centre(box), glm::dvec3(1, 2, 3));
  include(box, glm::dvec3(-1, 6, 3));
  EXPECT_EQ(extent(box), glm::dvec3(2, 4, 0));
  EXPECT_EQ(centre(box), glm::dvec3(0, 4, 3));
  Box other;
  include(other, glm::dvec3(0, 0, 7));
  include(box, other);
  EXPECT_EQ(extent(box), glm::dvec3(2, 6, 4));
  EXPECT_DOUBLE_EQ(diagonal(box), std::sqrt(56.0));
}

TEST(Box, BoundsLeaveOutVerticesWithoutTriangles) {
  Mesh mesh;
  EXPECT_TRUE(isEmpty(bounds(mesh)));
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {900, 900, 900}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_EQ(extent(bounds(mesh)), glm::dvec3(1, 2, 0));
}

TEST(Mesh, KnowsItsFilesByExtension) {
  for (const char* name : {"a.obj", "a.PLY", "b/c.Stl", "x.y.off"}) EXPECT_TRUE(isMeshFile(name)) << name;
  for (const char* name : {"a", "a.om", "a.gltf", "obj", ".obj", "a.obj.gz"}) EXPECT_FALSE(isMeshFile(name)) << name;
  EXPECT_THAT(errorOf("a.om", "x"), testing::HasSubstr("is not a mesh file"));
}

TEST(Mesh, EveryFormatGivesTheSameMesh) {
  const TriangleMesh expected = torus(12, 7, true);
  for (const auto& [name, bytes] : everyFormat(expected)) {
    SCOPED_TRACE(name);
    const MeshFile file = mustRead(name, bytes);
    const Mesh& mesh = file.mesh;
    ASSERT_EQ(mesh.triangles.size(), expected.triangles.size());
    EXPECT_EQ(file.report.polygons, expected.triangles.size());
    EXPECT_EQ(file.report.triangulated + file.report.badIndexFaces + file.report.nonFiniteFaces + file.report.shortFaces, 0u);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(mesh.positions[mesh.triangles[t][c]], expected.positions[expected.triangles[t][c]]);
      }
    }
    const bool soup = name.ends_with("stl") || name.ends_with("STL");
    EXPECT_EQ(mesh.positions.size(), soup ? 3 * expected.triangles.size() : expected.positions.size());
    ASSERT_EQ(mesh.parts.size(), 1u);
    EXPECT_EQ(mesh.parts[0].firstTriangle, 0u);
    EXPECT_EQ(mesh.parts[0].triangleCount, mesh.triangles.size());
    EXPECT_EQ(mesh.parts[0].material, -1);
    EXPECT_EQ(mesh.name, name.substr(0, name.find('.')));
    EXPECT_TRUE(mesh.normals.empty());
  }
}

TEST(Mesh, FarFromTheOriginKeepsEveryBit) {
  // 1e5 diagonals away; single floats would move vertices by up to a hundredth of the diagonal.
  const TriangleMesh expected = torus(8, 5, false, 1.0, glm::dvec3(2.5e5, -2.5e5, 1e5));
  for (const char* name : {"text.obj", "text.off", "text.ply", "little_double.ply", "big_double.ply", "text.stl"}) {
    const MeshFile file = mustRead(name, everyFormat(expected).at(name));
    for (std::size_t t = 0; t < expected.triangles.size(); ++t) {
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(file.mesh.positions[file.mesh.triangles[t][c]], expected.positions[expected.triangles[t][c]]) << name;
      }
    }
  }
}

TEST(Mesh, AgreesWithOpenMesh) {
  const TriangleMesh sample = torus(10, 6, true);
  const TemporaryFolder folder;
  for (const char* name : {"text.obj", "text.off", "text.ply", "text.stl", "binary.STL"}) {
    SCOPED_TRACE(name);
    // OpenMesh's OFF reader knows no comments.
    const std::string bytes =
        std::string(name) == "text.off" ? std::string("OFF\n").append(test::offText(sample), 16) : everyFormat(sample).at(name);
    test::spill(folder.path / name, bytes);
    OpenMesh::PolyMesh_ArrayKernelT<> theirs;
    ASSERT_TRUE(OpenMesh::IO::read_mesh(theirs, (folder.path / name).string()));
    const auto ours = readMesh(folder.path / name);
    ASSERT_TRUE(ours.ok()) << message(ours.error());
    ASSERT_EQ(theirs.n_faces(), ours.value().mesh.triangles.size());
    std::size_t t = 0;
    for (const auto face : theirs.faces()) {
      // OpenMesh may begin a face at another corner: compare its centre.
      OpenMesh::Vec3d centre(0, 0, 0);
      for (const auto vertex : theirs.fv_range(face)) centre += OpenMesh::vector_cast<OpenMesh::Vec3d>(theirs.point(vertex));
      glm::dvec3 sum(0.0);
      for (int c = 0; c < 3; ++c) sum += ours.value().mesh.positions[ours.value().mesh.triangles[t][c]];
      for (int axis = 0; axis < 3; ++axis) ASSERT_NEAR(centre[static_cast<std::size_t>(axis)], sum[axis], 1e-12);
      ++t;
    }
  }
}

TEST(Mesh, OffRoundTripsBitForBit) {
  const TemporaryFolder folder;
  const bool held = rc::check("any finite positions", [&](const std::vector<std::tuple<double, double, double>>& points) {
    Mesh mesh;
    for (const auto& [x, y, z] : points) mesh.positions.emplace_back(x, y, z);
    mesh.positions.emplace_back(-0.0, std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::max());
    const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    mesh.triangles = {{last, 0, last / 2}, {0, 0, 0}};
    const auto path = folder.path / "a.off";
    RC_ASSERT(writeOff(path, mesh).ok());
    const auto read = readMesh(path);
    RC_ASSERT(read.ok());
    RC_ASSERT(read.value().mesh.triangles == mesh.triangles);
    RC_ASSERT(contentHash(std::as_bytes(std::span(read.value().mesh.positions))) == contentHash(std::as_bytes(std::span(mesh.positions))));
  });
  EXPECT_TRUE(held);
}

TEST(Mesh, ObjSpellings) {
  const std::string quad = kTwoTriangles;
  const std::pair<const char*, std::string> same[] = {
      {"plain", quad + "f 1 2 3\nf 1 3 4\n"},
      {"negative indices", quad + "f -4 -3 -2\nf -4 -2 -1\n"},
      {"negative indices count from the line they are on", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\n"},
      {"texture and normal indices", quad + "vt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3/1\nf 1/1/-1 3/9/9 4\n"},
      {"continued lines", quad + "f 1 \\\n2 \\\r\n3\nf 1 3\\\n 4\n"},
      {"blanks and tabs", quad + "\n  f\t1   2 3  \n\nf 1 3 4\t\n"},
      {"comments", quad + "f 1 2 3 # the first\n#f 1 2 3\nf 1 3 4\n"},
      {"old keyword, groups, materials", "mtllib missing.mtl\n" + quad + "g a b\nusemtl x\ns 1\nfo 1 2 3\np 1\nl 1 2\nf 1 3 4\n"},
      {"no last line end", quad + "f 1 2 3\nf 1 3 4"},
      {"colours and weights", "v 0 0 0 1\nv 1 0 0 .5 .5 .5\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"},
      {"plus signs and exponents", "v +0 0. -0e0\nv 1e0 0 0\nv +1.0 10E-1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"}};
  for (const auto& [what, text] : same) {
    const MeshFile file = mustRead("a.obj", text);
    EXPECT_THAT(file.mesh.triangles, testing::ElementsAre(glm::uvec3(0, 1, 2), glm::uvec3(0, 2, 3))) << what;
    EXPECT_THAT(file.mesh.positions,
                testing::ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(1, 1, 0), glm::dvec3(0, 1, 0)))
        << what;
    EXPECT_EQ(mustRead("a.obj", withLineEnds(text, "\r\n")).mesh.triangles.size(), 2u) << what << ", CRLF";
  }
}

TEST(Mesh, OffSpellings) {
  const std::pair<const char*, const char*> same[] = {
      {"plain", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
      {"no edges, colours", "OFF 3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n"},
      {"comments and blanks", "# first\n\n OFF # here\n# and\n3 1 0 # there\n0 0 0\n\n1 0 0 # x\n0 1 0\n3 0 1 2"},
      {"keyword glued", "\t  OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
      {"no keyword", "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
      {"colours", "COFF\n3 1 0\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2\n"},
      {"normals, texture", "STCNOFF\n3 1 0\n0 0 0 0 0 1 1 1 1 1 .5 .5\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"},
      {"CRLF", "OFF\r\n3 1 0\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2\r\n"},
      {"CR", "OFF\r3 1 0\r0 0 0\r1 0 0\r0 1 0\r3 0 1 2\r"},
      {"broken lines", "OFF\n3 1 0\n0 0\n0\n1 0 0\n0 1 0\n3 0\n1 2\n"}};
  for (const auto& [what, text] : same) {
    const MeshFile file = mustRead("a.off", text);
    EXPECT_THAT(file.mesh.triangles, testing::ElementsAre(glm::uvec3(0, 1, 2))) << what;
    EXPECT_THAT(file.mesh.positions, testing::ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0))) << what;
  }
  EXPECT_THAT(errorOf("a.off", "4OFF\n1 1 0\n"), testing::HasSubstr("three dimensions"));
  EXPECT_THAT(errorOf("a.off", "OOF\n1 1 0\n"), testing::HasSubstr("is not an OFF file"));
}

TEST(Mesh, PlySpellings) {
  const std::string head = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string corners = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const std::pair<const char*, std::string> same[] = {
      {"plain", "ply\nformat ascii 1.0\n" + head + "element face 2\nproperty list uchar int vertex_indices\nend_header\n" + corners +
                    "3 0 1 2\n3 0 2 3\n"},
      {"more on a face line than declared", "ply\nformat ascii 1.0\n" + head +
                                                "element face 2\nproperty list uchar int vertex_indices\nend_header\n" + corners +
                                                "3 0 1 2 9 9\n3 0 2 3 9\n"},
      {"other elements and lists before, between and after",
       "ply\nformat ascii 1.0\ncomment x y z\nobj_info none\nelement camera 1\nproperty float a\nproperty list int float b\n" + head +
           "element face 2\nproperty list uchar float texcoord\nproperty list uint8 uint32 vertex_index\nproperty uchar red\n"
           "element edge 1\nproperty int a\nend_header\n5 2 .5 .5\n" +
           corners + "2 .1 .2 3 0 1 2 255\n0 3 0 2 3 255\n1\n"},
      {"strips", "ply\nformat ascii 1.0\n" + head + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" + corners +
                     "10 0 1 2 2 -1 -1 0 2 3 3\n"}};
  for (const auto& [what, text] : same) {
    EXPECT_THAT(mustRead("a.ply", text).mesh.triangles, testing::ElementsAre(glm::uvec3(0, 1, 2), glm::uvec3(0, 2, 3))) << what;
  }
  // A strip turns every second triangle round.
  const std::string strip = "ply\nformat ascii 1.0\n" + head + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
                            corners + "4 0 1 3 2\n";
  EXPECT_THAT(mustRead("a.ply", strip).mesh.triangles, testing::ElementsAre(glm::uvec3(0, 1, 3), glm::uvec3(1, 2, 3)));
}

TEST(Mesh, PlyHeadersWithBareReturns) {
  // The body begins with the byte \n, which must not be taken for a line end.
  const std::string little = test::plyBinary(torus(5, 4, true), test::ByteOrder::little, false);
  const std::size_t body = little.find("end_header\n") + 11;
  for (const char* lineEnd : {"\r", "\r\n", "\n"}) {
    std::string bytes = withLineEnds(little.substr(0, body), lineEnd);
    bytes += '\n';  // the first byte of a float that is stepped over (nx)
    bytes += little.substr(body + 1);
    EXPECT_EQ(mustRead("a.ply", bytes).mesh.triangles.size(), 40u);
  }
}

TEST(Mesh, StlSpellings) {
  const std::string facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  EXPECT_EQ(mustRead("a.stl", "solid a\n" + facet + "endsolid a\nsolid b\n" + facet + facet + "endsolid b\n").mesh.triangles.size(), 3u);
  EXPECT_EQ(mustRead("a.stl",
                     "  SOLID\r\nFACET NORMAL 0 0 1\r\nOUTER LOOP\r\nVERTEX 0 0 0\r\nVERTEX 1 0 0\r\nVERTEX 0 1 0\r\nENDLOOP\r\n"
                     "ENDFACET\r\nENDSOLID\r\n")
                .mesh.triangles.size(),
            1u);
  EXPECT_EQ(mustRead("a.stl", test::stlBinary(torus(4, 3, true)) + "trailing").mesh.triangles.size(), 24u);
  EXPECT_THAT(errorOf("a.stl", "solid a\n" + facet), testing::HasSubstr("cut short"));
  EXPECT_THAT(errorOf("a.stl", "hello"), testing::HasSubstr("is not an STL file"));
}

TEST(Mesh, FacesThatCannotBeUsedAreLeftOutAndCounted) {
  const std::string quad = kTwoTriangles;
  const MeshFile indices = mustRead("a.obj", quad + "f 1 2 3\nf 1 2 5\nf 0 1 2\nf 1 2 99999999999999\nf -5 1 2\nf 1 2\nf 1 3 4\n");
  EXPECT_EQ(indices.mesh.triangles.size(), 2u);
  EXPECT_EQ(indices.report.badIndexFaces, 4u);
  EXPECT_EQ(indices.report.shortFaces, 1u);
  EXPECT_EQ(indices.report.polygons, 7u);

  const MeshFile off = mustRead("a.off", "OFF\n3 5 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 3\n3 0 -1 2\n2 0 1\n3 0 1 4294967295\n");
  EXPECT_EQ(off.mesh.triangles.size(), 1u);
  EXPECT_EQ(off.report.badIndexFaces, 3u);
  EXPECT_EQ(off.report.shortFaces, 1u);

  for (const char* value : {"nan", "inf", "-inf", "1e999"}) {
    const MeshFile file = mustRead("a.obj", quad + "v 0 " + value + " 0\nf 1 2 3\nf 1 2 5\nf 5 3 4 2\n");
    EXPECT_EQ(file.report.nonFiniteVertices, 1u) << value;
    EXPECT_EQ(file.report.nonFiniteFaces, 2u);
    EXPECT_EQ(file.mesh.triangles.size(), 1u);
    for (const glm::dvec3& p : file.mesh.positions) EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  }
  EXPECT_THAT(errorOf("a.obj", quad + "f 7 8 9\n"), testing::HasSubstr("no usable triangle"));
  EXPECT_THAT(errorOf("a.obj", quad), testing::HasSubstr("holds no faces"));
}

TEST(Mesh, PolygonsAreTriangulated) {
  const MeshFile file = mustRead("a.obj", std::string(kTwoTriangles) + "v 2 0 0\nf 1 2 3 4\nf 1 2 3\nf 2 5 3 4 1\n");
  EXPECT_EQ(file.mesh.triangles.size(), 2u + 1u + 3u);
  EXPECT_EQ(file.report.polygons, 3u);
  EXPECT_EQ(file.report.triangulated, 2u);
}

TEST(Mesh, ErrorsNameTheFileTheLineAndTheReason) {
  const TemporaryFolder folder;
  const auto missing = readMesh(folder.path / "missing.obj");
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(message(missing.error()), testing::AllOf(testing::HasSubstr("missing.obj"), testing::HasSubstr("no such file")));
  EXPECT_EQ(errorOf("a.obj", "v 0 0 0\nv 1 x 0\n"), "line 2|'x' is not a coordinate");
  EXPECT_EQ(errorOf("a.obj", "v 0 0 0\nf 1 a 1\n"), "line 2|'a' is not a corner of a face");
  EXPECT_EQ(errorOf("a.off", "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n"), "line 8|is cut short: ends after 2 of 3 faces");
  EXPECT_THAT(errorOf("a.off", "OFF\n353535235358 6 0\n0 0 0\n"), testing::HasSubstr("declares 353535235358 vertices"));
  EXPECT_THAT(errorOf("a.ply",
                      "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n"
                      "end_header\n0 0 0\n"),
              testing::HasSubstr("declares 4000000000 elements 'vertex'"));
  for (const char* name : {"a.obj", "a.off", "a.ply", "a.stl"}) EXPECT_FALSE(readAs(name, "").ok()) << name;
}

TEST(Mesh, LimitsOfTheCallerHold) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "memory is not limited under AddressSanitizer";
#endif
  const TemporaryFolder folder;
  const fs::path path = folder.path / "a.stl";
  // Two million facets of zeros, most of them a hole in the file: more than this process has freed and the child could use again.
  test::spill(path, std::string(80, ' ') + std::string("\x80\x84\x1e\0", 4));
  fs::resize_file(path, 84 + std::uintmax_t{50} * 2'000'000);
  SandboxLimits limits;
  limits.memoryBytes = 16 << 20;
  const auto starved = readMesh(path, limits);
  ASSERT_FALSE(starved.ok());
  EXPECT_THAT(message(starved.error()), testing::HasSubstr("needs more than 16 MB"));
  limits = {};
  limits.resultBytes = 16 << 20;
  const auto refused = readMesh(path, limits);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(message(refused.error()), testing::HasSubstr("holds more than the 16 MB"));
}

}  // namespace
}  // namespace overcast
