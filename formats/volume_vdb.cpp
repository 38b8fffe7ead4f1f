// The only file that includes OpenVDB: it takes long to compile.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <istream>
#include <mutex>
#include <span>
#include <sstream>
#include <streambuf>

#include <Imath/half.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include "formats/files.h"
#include "formats/packing.h"
#include "formats/volume.h"
#include "formats/volume_parse.h"

namespace overcast {
namespace {

constexpr float kLargestHalf = 65504.0f;
constexpr const char* kGridName = "distance";
constexpr const char* kVersionKey = "overcast_version";
constexpr const char* kInsideKey = "overcast_inside";
constexpr const char* kThicknessKey = "overcast_sheet_thickness";
constexpr const char* kSignKey = "overcast_sign_method";
constexpr const char* kSizeKey = "overcast_size";
constexpr const char* kStepKey = "overcast_step";
// Magic number (8 bytes), file version, library version (2 x 4), "has offsets" (1); then the UUID as text.
constexpr std::size_t kUuidPosition = 8 + 4 + 4 + 4 + 1;
constexpr std::size_t kUuidLength = 36;
constexpr std::uint64_t kLargestFile = std::uint64_t{4} << 30;

/// Before any fork as well: the registry takes a lock that a forked child could otherwise inherit locked.
void initialiseOpenVdb() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

/// A UniformScaleTranslateMap as OpenVDB writes it: its name, then translation, scale and what follows from the scale.
std::string serialisedMap(const glm::dvec3& translation, double scale) {
  std::ostringstream out;
  openvdb::writeString(out, openvdb::math::UniformScaleTranslateMap::mapType());
  openvdb::Vec3d(translation.x, translation.y, translation.z).write(out);
  for (const double value : {scale, scale, 1.0 / scale, 1.0 / (scale * scale), 0.5 / scale}) openvdb::Vec3d(value).write(out);
  return out.str();
}

/// OpenVDB deflates no grid whose class says level set; readers do not mind.
constexpr const char* kClass = "level set";
constexpr const char* kStandInClass = "level_set";

constexpr glm::dvec3 kStandInTranslation{3.0, 5.0, 7.0};
constexpr double kStandInScale = 2.0;

void fillLeaf(openvdb::FloatTree::LeafNodeType& leaf, const Volume& volume) {
  const openvdb::Coord first = leaf.origin();
  const auto size = glm::ivec3(volume.size);
  const auto last = openvdb::Coord::minComponent(first.offsetBy(7), openvdb::Coord(size.x - 1, size.y - 1, size.z - 1));
  for (int k = first.z(); k <= last.z(); ++k)
    for (int j = first.y(); j <= last.y(); ++j)
      for (int i = first.x(); i <= last.x(); ++i) leaf.setValueOn(openvdb::Coord(i, j, k), volume.distance[sampleIndex(volume, i, j, k)]);
}

/// Whether half floats hold every distance exactly; of 8-bit ones they do unless the volume is minute or enormous.
bool areHalves(const Volume& volume) {
  return std::all_of(volume.distance.begin(), volume.distance.end(), [](float d) { return static_cast<float>(Imath::half(d)) == d; });
}

/// The grid with a stand-in for its transform: OpenVDB's own would refuse scales below 1.4e-5 (their cube counts as zero) and take the
/// scale from differences of mapped points, which loses its last bits. Of 8 bits, with one for its class. serialise() puts the true ones in
/// their place.
openvdb::FloatGrid::Ptr gridOf(const Volume& volume, VolumeBits bits) {
  // Beyond the box lies "far": the largest distance, so that half floats hold it too.
  const float largest = *std::max_element(volume.distance.begin(), volume.distance.end());
  const float background = largest > 0.0f ? largest : static_cast<float>(volume.voxelSize);
  auto grid = openvdb::FloatGrid::create(background);
  for (int k = 0; k < volume.size.z; k += 8)
    for (int j = 0; j < volume.size.y; j += 8)
      for (int i = 0; i < volume.size.x; i += 8) fillLeaf(*grid->tree().touchLeaf(openvdb::Coord(i, j, k)), volume);
  grid->setName(kGridName);
  grid->insertMeta(openvdb::GridBase::META_GRID_CLASS, openvdb::StringMetadata(bits == VolumeBits::snorm8 ? kStandInClass : kClass));
  const auto transform = openvdb::math::Transform::createLinearTransform(kStandInScale);
  transform->postTranslate({kStandInTranslation.x, kStandInTranslation.y, kStandInTranslation.z});
  grid->setTransform(transform);
  grid->setSaveFloatAsHalf(bits == VolumeBits::half || (bits == VolumeBits::snorm8 && areHalves(volume)));
  grid->setCreator("overcast");
  grid->insertMeta(kVersionKey, openvdb::Int32Metadata(kVolumeVersion));
  grid->insertMeta(kSignKey, openvdb::StringMetadata(volume.signMethod));
  grid->insertMeta(kSizeKey, openvdb::Vec3IMetadata(openvdb::Vec3i(volume.size.x, volume.size.y, volume.size.z)));
  if (volume.inside != Inside::unstated) grid->insertMeta(kInsideKey, openvdb::StringMetadata(name(volume.inside)));
  if (volume.sheetThickness > 0.0) grid->insertMeta(kThicknessKey, openvdb::DoubleMetadata(volume.sheetThickness));
  if (bits == VolumeBits::snorm8) grid->insertMeta(kStepKey, openvdb::FloatMetadata(volume.step));
  return grid;
}

/// A UUID of version 8 (RFC 9562: made by the application) from the hash of everything else in the file.
std::string uuidFrom(const std::string& hash) {
  std::string digits = hash;
  digits[12] = '8';
  digits[16] = 'a';
  return digits.substr(0, 8) + '-' + digits.substr(8, 4) + '-' + digits.substr(12, 4) + '-' + digits.substr(16, 4) + '-' +
         digits.substr(20, 12);
}

/// `volume` is as stored in `bits`.
std::string serialise(const Volume& volume, VolumeBits bits) {
  std::ostringstream out(std::ios::binary);
  openvdb::io::Stream stream(out);
  // Few distinct values: deflate brings them near 8 bits each, which blosc's matches do not.
  const std::uint32_t method = bits == VolumeBits::snorm8 ? openvdb::io::COMPRESS_ZIP : openvdb::io::COMPRESS_BLOSC;
  stream.setCompression(method | openvdb::io::COMPRESS_ACTIVE_MASK);
  stream.setGridStatsMetadataEnabled(false);
  stream.write(openvdb::GridCPtrVec{gridOf(volume, bits)});
  std::string bytes = std::move(out).str();
  const std::string standIn = serialisedMap(kStandInTranslation, kStandInScale);
  const std::size_t map = bytes.find(standIn);
  OVERCAST_REQUIRE(map != std::string::npos && bytes.find(standIn, map + 1) == std::string::npos,
                   "the transform is not in OpenVDB's {} bytes just once", bytes.size());
  bytes.replace(map, standIn.size(), serialisedMap(volume.origin, volume.voxelSize));
  // Metadata stand in the order of their keys, so nobody's text comes before this one.
  if (bits == VolumeBits::snorm8) bytes.replace(bytes.find(kStandInClass), std::strlen(kClass), kClass);
  const std::string random = stream.getUniqueTag();
  OVERCAST_REQUIRE(random.size() == kUuidLength && bytes.compare(kUuidPosition, kUuidLength, random) == 0,
                   "OpenVDB's header does not hold the UUID {} at byte {}", random, kUuidPosition);
  std::fill_n(bytes.begin() + kUuidPosition, kUuidLength, '0');
  bytes.replace(kUuidPosition, kUuidLength, uuidFrom(contentHash(std::as_bytes(std::span(bytes)))));
  return bytes;
}

/// A stream over bytes that are already in memory, without a copy.
class MemoryBuffer : public std::streambuf {
 public:
  explicit MemoryBuffer(std::span<const std::byte> bytes) {
    // The interface wants char*, but nothing writes through it.
    auto* first = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));
    setg(first, first, first + bytes.size());
  }

 protected:
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const off_type base = from == std::ios_base::beg ? 0 : from == std::ios_base::cur ? gptr() - eback() : egptr() - eback();
    const off_type target = base + offset;
    if (target < 0 || target > egptr() - eback()) return pos_type(off_type(-1));
    setg(eback(), eback() + target, egptr());
    return pos_type(target);
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override {
    return seekoff(off_type(position), std::ios_base::beg, mode);
  }
};

/// Origin and voxel size of a grid whose index space is only scaled evenly and moved.
Result<Done> takeTransform(const openvdb::FloatGrid& grid, const openvdb::Coord& first, const std::string& file, Volume& volume) {
  const openvdb::math::Transform& transform = grid.transform();
  const Error skewed{file, kGridName, "its transform is not a uniform scale and a translation"};
  if (!transform.isLinear()) return skewed;
  const auto map = transform.baseMap();
  const double h = map->applyJacobian(openvdb::Vec3d(1, 0, 0)).x();
  if (!std::isfinite(h) || h <= 0.0) return Error{file, kGridName, "its voxel size is not positive"};
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::Vec3d unit(0.0);
    unit[axis] = 1.0;
    openvdb::Vec3d image = map->applyJacobian(unit) / h;
    image[axis] -= 1.0;
    if (!(image.length() <= 1e-6)) return skewed;
  }
  const openvdb::Vec3d origin = map->applyMap(first.asVec3d());
  if (!std::isfinite(origin.x()) || !std::isfinite(origin.y()) || !std::isfinite(origin.z()))
    return Error{file, kGridName, "its origin is not finite"};
  volume.voxelSize = h;
  volume.origin = {origin.x(), origin.y(), origin.z()};
  return Done{};
}

Result<Done> takeMetadata(const openvdb::FloatGrid& grid, const std::string& file, Volume& volume) {
  if (const auto version = grid.getMetadata<openvdb::Int32Metadata>(kVersionKey))
    if (version->value() < 1 || version->value() > kVolumeVersion)
      return Error{file, kVersionKey, fmt::format("is {}, this program reads up to {}", version->value(), kVolumeVersion)};
  if (const auto size = grid.getMetadata<openvdb::Vec3IMetadata>(kSizeKey))
    if (size->value() != openvdb::Vec3i(volume.size.x, volume.size.y, volume.size.z))
      return Error{file, kSizeKey, "does not match the active voxels"};
  if (const auto sign = grid.getMetadata<openvdb::StringMetadata>(kSignKey)) volume.signMethod = sign->value();
  if (const auto inside = grid.getMetadata<openvdb::StringMetadata>(kInsideKey)) {
    const auto known = insideNamed(inside->value());
    if (!known) return Error{file, kInsideKey, fmt::format("'{}' is not known", inside->value())};
    volume.inside = *known;
  }
  if (const auto thickness = grid.getMetadata<openvdb::DoubleMetadata>(kThicknessKey)) volume.sheetThickness = thickness->value();
  if (const auto step = grid.getMetadata<openvdb::FloatMetadata>(kStepKey)) {
    if (!(step->value() > 0.0f)) return Error{file, kStepKey, "is not positive"};
    volume.step = step->value();
  }
  return Done{};
}

Result<Done> takeSize(const openvdb::CoordBBox& box, const std::string& file, Volume& volume) {
  if (box.empty()) return Error{file, kGridName, "has no active voxels"};
  const openvdb::Coord first = box.min();
  const openvdb::Coord last = box.max();
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t side = std::int64_t{last.data()[axis]} - first.data()[axis] + 1;
    if (side < 2 || side > kMaxVolumeSide)
      return Error{file, kGridName, fmt::format("has {} samples along an axis, allowed are 2 to {}", side, kMaxVolumeSide)};
    volume.size[axis] = static_cast<int>(side);
  }
  return Done{};
}

Result<Done> takeDistances(const openvdb::FloatGrid& grid, const openvdb::Coord& first, const std::string& file, Volume& volume) {
  volume.distance.reserve(sampleIndex(volume, 0, 0, volume.size.z));
  auto reader = grid.getConstAccessor();
  for (int k = 0; k < volume.size.z; ++k)
    for (int j = 0; j < volume.size.y; ++j)
      for (int i = 0; i < volume.size.x; ++i) volume.distance.push_back(reader.getValue(first.offsetBy(i, j, k)));
  if (!isWhole(volume))
    return Error{file, kGridName,
                 volume.step == 0.0f ? "holds a value that is not finite"
                                     : fmt::format("holds a value that is not one of the 255 multiples of {} = {}", kStepKey, volume.step)};
  return Done{};
}

Result<openvdb::FloatGrid::Ptr> findGrid(std::span<const std::byte> bytes, const std::string& file) {
  MemoryBuffer buffer(bytes);
  std::istream in(&buffer);
  in.exceptions(std::ios::badbit | std::ios::failbit);
  // Delayed loading would copy the file into a temporary one that a killed reader leaves behind.
  const openvdb::GridPtrVecPtr grids = openvdb::io::Stream(in, false).getGrids();
  if (grids)
    for (const openvdb::GridBase::Ptr& grid : *grids) {
      if (!grid || grid->getName() != kGridName) continue;
      const auto distances = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
      if (!distances) return Error{file, kGridName, fmt::format("is a grid of type {}, not float", grid->type())};
      return distances;
    }
  return Error{file, "", fmt::format("has no grid named '{}'", kGridName)};
}

std::vector<std::byte> packed(const Volume& volume) {
  std::vector<std::byte> bytes;
  bytes.reserve(volume.distance.size() * sizeof(float) + 256);
  pack(bytes, volume.size);
  pack(bytes, volume.origin);
  pack(bytes, volume.voxelSize);
  pack(bytes, volume.step);
  pack(bytes, volume.inside);
  pack(bytes, volume.sheetThickness);
  packText(bytes, volume.signMethod);
  packAll(bytes, std::span<const float>(volume.distance));
  return bytes;
}

}  // namespace

Result<Volume> parseVolume(std::span<const std::byte> bytes, const std::string& file) {
  initialiseOpenVdb();
  try {
    const auto grid = findGrid(bytes, file);
    if (!grid) return grid.error();
    const openvdb::FloatGrid& distances = *grid.value();
    const openvdb::CoordBBox box = distances.evalActiveVoxelBoundingBox();
    Volume volume;
    for (const auto& step : {takeSize(box, file, volume), takeMetadata(distances, file, volume)})
      if (!step) return step.error();
    if (const auto step = takeTransform(distances, box.min(), file, volume); !step) return step.error();
    if (const auto step = takeDistances(distances, box.min(), file, volume); !step) return step.error();
    return volume;
  } catch (const std::bad_alloc&) {
    throw;  // the sandbox says how much is allowed
  } catch (const std::exception& failure) {
    return Error{file, "", fmt::format("not a readable OpenVDB file ({})", failure.what())};
  }
}

Result<std::vector<std::byte>> encodeVolume(const Volume& volume, VolumeBits bits) {
  OVERCAST_REQUIRE(isWhole(volume), "not whole: a volume of {} x {} x {} samples, spacing {}, with {} distances", volume.size.x,
                   volume.size.y, volume.size.z, volume.voxelSize, volume.distance.size());
  const VolumeBits chosen = chooseBits(volume, bits);
  for (const float d : volume.distance)
    if (chosen == VolumeBits::half && std::abs(d) > kLargestHalf)
      return Error{"", "", fmt::format("the distance {} does not fit a half float", d)};
  initialiseOpenVdb();
  const std::string text = chosen == VolumeBits::snorm8 ? serialise(asStored(volume, chosen), chosen) : serialise(volume, chosen);
  const auto bytes = std::as_bytes(std::span(text));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

Result<std::uint64_t> writeVolume(const std::filesystem::path& path, const Volume& volume, VolumeBits bits) {
  const auto bytes = encodeVolume(volume, bits);
  if (!bytes) return Error{path.string(), bytes.error().place, bytes.error().reason};
  if (const auto written = writeFileAtomically(path, bytes.value()); !written) return written.error();
  return bytes.value().size();
}

Result<Volume> readVolume(const std::filesystem::path& path, const SandboxLimits& limits) {
  initialiseOpenVdb();
  const std::string file = path.string();
  const auto result = runSandboxed(path, limits, [&]() -> Result<std::vector<std::byte>> {
    const auto bytes = readFile(path, kLargestFile);
    if (!bytes) return bytes.error();
    const auto volume = parseVolume(bytes.value(), file);
    if (!volume) return volume.error();
    return packed(volume.value());
  });
  if (!result) return result.error();
  Unpacker from(result.value());
  Volume volume;
  volume.size = from.one<glm::ivec3>();
  volume.origin = from.one<glm::dvec3>();
  volume.voxelSize = from.one<double>();
  volume.step = from.one<float>();
  volume.inside = from.one<Inside>();
  volume.sheetThickness = from.one<double>();
  volume.signMethod = from.text();
  volume.distance = from.all<float>();
  // A corrupt child may hand over anything: what it promised is checked again.
  if (!from.atEnd() || !isWhole(volume)) return Error{file, "", "its reader returned something that is not a volume"};
  return volume;
}

}  // namespace overcast
