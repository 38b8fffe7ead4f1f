#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/FastSweeping.h>
#include <openvdb/tools/MeshToVolume.h>

#include <cmath>

#include "tests/bench/peers.h"

namespace overcast::bench {
namespace {

constexpr float kSweepBand = 3.0f;

/// The mesh in index space of the grid.
openvdb::FloatGrid::Ptr signedBand(const Mesh& mesh, const Grid& grid, float band) {
  std::vector<openvdb::Vec3s> points;
  points.reserve(mesh.positions.size());
  for (const glm::dvec3& position : mesh.positions) {
    const glm::dvec3 p = (position - grid.origin) / grid.voxelSize;
    points.emplace_back(static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z));
  }
  std::vector<openvdb::Vec3I> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) triangles.emplace_back(t.x, t.y, t.z);
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(points, triangles);
  return openvdb::tools::meshToVolume<openvdb::FloatGrid>(adapter, *openvdb::math::Transform::createLinearTransform(1.0), band, band);
}

openvdb::CoordBBox boxOf(const Grid& grid) {
  return {openvdb::Coord(0), openvdb::Coord(grid.size.x - 1, grid.size.y - 1, grid.size.z - 1)};
}

using DenseGrid = openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ>;

std::vector<float> toDense(const openvdb::FloatGrid& volume, const Grid& grid) {
  DenseGrid dense(boxOf(grid));
  openvdb::tools::copyToDense(volume, dense);
  std::vector<float> distance(sampleCount(grid));
  const auto voxel = static_cast<float>(grid.voxelSize);
  for (std::size_t i = 0; i < distance.size(); ++i) distance[i] = voxel * std::abs(dense.data()[i]);
  return distance;
}

}  // namespace

std::vector<float> openvdbBand(const Mesh& mesh, const Grid& grid, double bandVoxels) {
  openvdb::initialize();
  return toDense(*signedBand(mesh, grid, static_cast<float>(bandVoxels)), grid);
}

std::vector<float> openvdbSweep(const Mesh& mesh, const Grid& grid) {
  openvdb::initialize();
  const openvdb::FloatGrid::Ptr band = signedBand(mesh, grid, kSweepBand);
  openvdb::MaskGrid box(false);
  box.denseFill(boxOf(grid), true);
  return toDense(*openvdb::tools::maskSdf(*band, box), grid);
}

std::vector<std::uint8_t> openvdbInside(const Mesh& mesh, const Grid& grid) {
  openvdb::initialize();
  DenseGrid dense(boxOf(grid));
  openvdb::tools::copyToDense(*signedBand(mesh, grid, kSweepBand), dense);
  std::vector<std::uint8_t> inside(sampleCount(grid));
  for (std::size_t i = 0; i < inside.size(); ++i) inside[i] = dense.data()[i] < 0.0f ? 1 : 0;
  return inside;
}

}  // namespace overcast::bench
