#include "bake/memory.h"

#include <malloc.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>

namespace overcast {
namespace {

constexpr int kLargeBlock = 1 << 20;
constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

/// The value of "<key>  <number> kB" in a file of /proc, in bytes; `otherwise` when it is not there.
std::uint64_t kilobytesOf(const char* file, const std::string& key, std::uint64_t otherwise) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with(key)) return std::stoull(line.substr(key.size())) * 1024;
  return otherwise;
}

std::uint64_t numberIn(const char* file, std::uint64_t otherwise) {
  std::ifstream stream(file);
  std::uint64_t number = 0;
  return stream >> number ? number : otherwise;
}

// What a bake takes beside its mesh, measured on up to a million triangles, connected and loose, and a third on top.
constexpr std::uint64_t kFixed = std::uint64_t{24} << 20;
constexpr std::uint64_t kPerVertex = 300;
constexpr std::uint64_t kPerTriangle = 900;
constexpr std::uint64_t kPerSample = 24;
constexpr std::uint64_t kPerErrorSample = 1024;

// Files: the shortest face of a text file ("f 1 2 3" and its line break) has 8 bytes, one of a binary file 13. The reader in its own
// process holds the file and the mesh, and this one what it sent while it is taken apart.
constexpr std::uint64_t kBytesPerTriangle = 8;
constexpr std::uint64_t kReadPerByte = 16;

std::uint64_t boundOf(std::uint64_t vertices, std::uint64_t triangles, std::uint64_t samples, const BakeSettings& settings) {
  return kFixed + kPerVertex * vertices + kPerTriangle * triangles + kPerSample * samples + kPerErrorSample * settings.volume.errorSamples;
}

/// Side of the largest volume that the settings lead to, where they fix it; 0 when there is none.
int largestSide(const BakeSettings& settings) {
  if (!settings.choice) return settings.volume.voxelSize > 0.0 ? kMaxResolution : settings.volume.resolution;
  return settings.choice->only.value_or(Representation::volume) == Representation::volume ? settings.choice->largest : 0;
}

std::uint64_t cube(int side) {
  const auto n = static_cast<std::uint64_t>(side);
  return n * n * n;
}

}  // namespace

std::uint64_t peakMemory() {
  return kilobytesOf("/proc/self/status", "VmHWM:", 0);
}

std::uint64_t residentMemory() {
  return kilobytesOf("/proc/self/status", "VmRSS:", 0);
}

std::uint64_t availableMemory() {
  const std::uint64_t system = kilobytesOf("/proc/meminfo", "MemAvailable:", kNoLimit);
  const std::uint64_t most = numberIn("/sys/fs/cgroup/memory.max", kNoLimit);
  const std::uint64_t used = numberIn("/sys/fs/cgroup/memory.current", 0);
  return std::min(system, most == kNoLimit ? kNoLimit : most - std::min(most, used));
}

void returnLargeBlocks() {
  ::mallopt(M_MMAP_THRESHOLD, kLargeBlock);
}

std::uint64_t meshMemory(const Mesh& mesh) {
  return mesh.positions.size() * sizeof(glm::dvec3) + mesh.normals.size() * sizeof(glm::vec3) + mesh.triangles.size() * sizeof(glm::uvec3);
}

std::uint64_t bakeMemory(const Mesh& mesh, const BakeSettings& settings) {
  std::uint64_t samples = 0;
  if (const int side = largestSide(settings); side > 0) {
    VolumeSettings volume = settings.volume;
    if (settings.choice) {
      volume.resolution = side;
      volume.voxelSize = 0.0;
    }
    const auto grid = volumeGrid(bounds(mesh), volume);
    if (grid) samples = sampleCount(grid.value());
  }
  return boundOf(mesh.positions.size(), mesh.triangles.size(), samples, settings);
}

FileMemory fileMemory(const std::filesystem::path& file, const BakeSettings& settings) {
  std::error_code code;
  const std::uint64_t size = std::filesystem::file_size(file, code);
  if (code) return {0, boundOf(0, 0, cube(largestSide(settings)), settings)};
  const std::uint64_t corners = size / kBytesPerTriangle;
  return {kReadPerByte * size, boundOf(corners, corners, cube(largestSide(settings)), settings)};
}

MemoryGate::Share::Share(MemoryGate& gate, std::uint64_t bytes) : gate_(gate), bytes_(bytes) {
  std::unique_lock lock(gate_.mutex_);
  gate_.freed_.wait(lock, [&] { return gate_.active_ == 0 || gate_.held_ + bytes_ <= gate_.limit_; });
  gate_.held_ += bytes_;
  ++gate_.active_;
}

MemoryGate::Share::~Share() {
  settle(0);
}

void MemoryGate::Share::shrink(std::uint64_t bytes) {
  {
    const std::lock_guard lock(gate_.mutex_);
    const std::uint64_t kept = std::min(bytes, bytes_);
    gate_.held_ -= bytes_ - kept;
    bytes_ = kept;
  }
  gate_.freed_.notify_all();
}

void MemoryGate::Share::settle(std::uint64_t bytes) {
  {
    const std::lock_guard lock(gate_.mutex_);
    gate_.held_ = gate_.held_ - bytes_ + bytes;
    bytes_ = bytes;
    if (active_) --gate_.active_;
    active_ = false;
  }
  gate_.freed_.notify_all();
}

}  // namespace overcast
