// Meshes known by formula, and their spelling in every format that readMesh takes, written here from the formats' descriptions.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace overcast::test {

struct TriangleMesh {
  std::vector<glm::dvec3> positions;
  std::vector<glm::uvec3> triangles;
};

/// A closed torus of 2 * around * across triangles with radii 1 and 0.25, scaled, then moved. Positions are single floats widened to
/// double when `singles`, so that every format can hold them.
TriangleMesh torus(int around, int across, bool singles, double scale = 1.0, const glm::dvec3& offset = glm::dvec3(0.0));

enum class ByteOrder { little, big };

std::string objText(const TriangleMesh& mesh);
std::string offText(const TriangleMesh& mesh);
/// As Geomview describes it (big, with the count of colour components after each face) or as other writers have it.
std::string offBinary(const TriangleMesh& mesh, ByteOrder order, bool colourCount);
std::string plyText(const TriangleMesh& mesh);
/// With a normal per vertex, a list per vertex and a flag per face that the reader must step over.
std::string plyBinary(const TriangleMesh& mesh, ByteOrder order, bool doubles);
std::string stlText(const TriangleMesh& mesh);
std::string stlBinary(const TriangleMesh& mesh);

/// File name -> content, each of the above once.
std::map<std::string, std::string> everyFormat(const TriangleMesh& mesh);

}  // namespace overcast::test
