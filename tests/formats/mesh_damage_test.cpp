// Damaged mesh files: whatever happens to the bytes, readMesh ends in a mesh that keeps its promises or in one line of error.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>
#include <string>

#include "formats/mesh.h"
#include "formats/mesh_reader.h"
#include "tests/formats/mesh_samples.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;
using test::everyFormat;
using test::TemporaryFolder;
using test::torus;

SandboxLimits tight() {
  SandboxLimits limits;
  limits.wallTime = std::chrono::milliseconds(5000);
  limits.memoryBytes = std::uint64_t{256} << 20;
  return limits;
}

/// What mesh.h promises of a mesh.
void expectPromises(const MeshFile& file) {
  for (const glm::dvec3& p : file.mesh.positions) ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  for (const glm::uvec3& t : file.mesh.triangles) ASSERT_LT(std::max({t.x, t.y, t.z}), file.mesh.positions.size());
  const MeshReadReport& report = file.report;
  ASSERT_LE(report.badIndexFaces + report.nonFiniteFaces + report.shortFaces + report.triangulated, report.polygons);
}

/// The whole way through the sandbox. The readers do not rely on it: none may crash or hang.
Result<MeshFile> readSafely(const fs::path& path, const std::string& bytes) {
  test::spill(path, bytes);
  Result<MeshFile> file = readMesh(path, tight());
  if (file.ok()) {
    EXPECT_FALSE(file.value().mesh.triangles.empty());
    expectPromises(file.value());
    return file;
  }
  EXPECT_EQ(file.error().file, path.string());
  EXPECT_EQ(message(file.error()).find('\n'), std::string::npos);
  for (const char* word : {"crashed", "took longer", "without an answer", "nonsense", "gave up"}) {
    EXPECT_EQ(file.error().reason.find(word), std::string::npos) << message(file.error());
  }
  return file;
}

/// The same without a child process, which is ten times as fast; not for OBJ, whose library writes to the terminal.
Result<MeshFile> readHere(const std::string& name, const std::string& bytes) {
  Result<RawMesh> raw = name.ends_with("off") ? parseOff(bytes) : name.ends_with("ply") ? parsePly(bytes) : parseStl(bytes);
  if (!raw.ok()) return raw.error();
  Result<MeshFile> file = finishMesh(std::move(raw).value());
  if (file.ok()) expectPromises(file.value());
  return file;
}

/// One random change: flipped, replaced, removed, repeated or inserted bytes, or a cut.
std::string damaged(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  const std::size_t changes = 1 + below(4);
  for (std::size_t i = 0; i < changes && bytes.size() > 8; ++i) {
    // Half of the changes hit the first bytes, where the counts are.
    const std::size_t at = below(below(2) == 0 ? std::min<std::size_t>(bytes.size(), 200) : bytes.size());
    const std::size_t length = std::min(1 + below(8), bytes.size() - at);
    switch (below(7)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(below(256));
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(at, bytes.substr(below(bytes.size()), length));
        break;
      case 4:
        bytes.resize(at);
        break;
      case 5:
        bytes[at] = "0123456789-.ennaif \n"[below(20)];
        break;
      default:
        bytes.insert(at, length, '9');
    }
  }
  return bytes;
}

TEST(DamagedMesh, EveryOutcomeIsAMeshOrAnError) {
  const TemporaryFolder folder;
  std::mt19937 random(20260101);
  std::size_t read = 0, refused = 0;
  for (const auto& [name, whole] : everyFormat(torus(6, 4, true))) {
    for (int i = 0; i < 300 && !HasFailure(); ++i) {
      SCOPED_TRACE(fmt::format("{} {}", name, i));
      const std::string bytes = damaged(whole, random);
      const bool sandboxed = name.ends_with("obj") || i % 10 == 0;
      const auto result = sandboxed ? readSafely(folder.path / name, bytes) : readHere(name, bytes);
      ++(result.ok() ? read : refused);
    }
  }
  // Both must happen, or the changes test nothing.
  EXPECT_GT(read, 300u);
  EXPECT_GT(refused, 300u);
}

TEST(DamagedMesh, AFileCutAnywhereIsRefused) {
  for (const auto& [name, whole] : everyFormat(torus(4, 3, true))) {
    if (name.ends_with("obj")) continue;  // OBJ declares no counts: a cut between two lines cannot be seen
    SCOPED_TRACE(name);
    // In text the last index may lose digits or its line end unseen: cut before it.
    const bool text = name.starts_with("text");
    const std::size_t last = text ? whole.find_last_of(" \n", whole.size() - 2) : whole.size() - 1;
    for (std::size_t size = 0; size <= last; ++size) {
      ASSERT_FALSE(readHere(name, whole.substr(0, size)).ok()) << "cut to " << size << " of " << whole.size() << " bytes";
    }
  }
}

TEST(DamagedMesh, AnObjCutInsideALineIsRefused) {
  const TemporaryFolder folder;
  const std::string whole = test::objText(torus(4, 3, true));
  const fs::path path = folder.path / "a.obj";
  const std::size_t lastLine = whole.rfind("\nf ") + 1;
  const std::size_t thirdCorner = whole.find_last_of(' ');
  for (std::size_t size = lastLine + 1; size <= thirdCorner; ++size) {
    EXPECT_FALSE(readSafely(path, whole.substr(0, size)).ok()) << whole.substr(lastLine, size - lastLine);
  }
}

TEST(DamagedMesh, AbsurdCountsCostNothing) {
  const TemporaryFolder folder;
  const std::pair<const char*, std::string> cases[] = {
      {"vertices.off", "OFF\n9000000000000000000 1 0\n0 0 0\n"},
      {"faces.off", "OFF\n1 4000000000 0\n0 0 0\n"},
      {"corners.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n"},
      {"negative.off", "OFF\n-3 1 0\n"},
      {"binary.off", std::string("OFF BINARY\n\x7f\xff\xff\xff\x7f\xff\xff\xff\0\0\0\0\0\0\0\0", 27)},
      {"vertices.ply",
       "ply\nformat binary_little_endian 1.0\nelement vertex 4294967295\nproperty float x\nproperty float y\n"
       "property float z\nend_header\n0123"},
      {"nothing.ply", "ply\nformat ascii 1.0\nelement empty 9000000000000000000\nend_header\n"},
      {"list.ply", std::string("ply\nformat binary_big_endian 1.0\nelement face 1\nproperty list uint uchar vertex_index\nend_header\n"
                               "\xff\xff\xff\xff\1\2\3")},
      {"facets.stl", std::string(80, ' ') + "\xff\xff\xff\xff" + std::string(50, '\0')}};
  for (const auto& [name, bytes] : cases) {
    const fs::path path = folder.path / name;
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_FALSE(readSafely(path, bytes).ok()) << name;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10)) << name;
  }
}

}  // namespace
}  // namespace overcast
