// Memory: how much a bake may need, how much is there, and a gate that lets no more jobs run at once than fit.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>

#include "bake/mesh_bake.h"

namespace overcast {

/// Largest resident size of this process so far and its resident size now, bytes; 0 where the system does not say.
std::uint64_t peakMemory();
std::uint64_t residentMemory();

/// Bytes that this process may still take without swapping: what the system says is available, less where its control group allows less.
std::uint64_t availableMemory();

/// Has large blocks of memory go back to the system when they are freed, from now on. Otherwise each thread keeps what its largest job
/// took, and bounding the jobs that run at once bounds nothing.
void returnLargeBlocks();

/// Bytes of a mesh in memory.
std::uint64_t meshMemory(const Mesh& mesh);

/// An upper bound on what baking this mesh takes beside the mesh itself, bytes, on any number of threads. Fitted to measurements
/// (tests/bake/memory_test.cpp holds the two together).
std::uint64_t bakeMemory(const Mesh& mesh, const BakeSettings& settings);

/// Upper bounds on what reading a file takes, and on what baking it then takes, judged by its size alone; the fixed part of a bake alone
/// when there is no such file.
struct FileMemory {
  std::uint64_t read = 0;
  std::uint64_t bake = 0;
};
FileMemory fileMemory(const std::filesystem::path& file, const BakeSettings& settings);

/// Lets jobs in while the sum of what is held is within the limit; one job is always let in, however large it is.
class MemoryGate {
 public:
  explicit MemoryGate(std::uint64_t limit) : limit_(limit) {}

  /// What a job holds until it is destroyed.
  class Share {
   public:
    Share(MemoryGate& gate, std::uint64_t bytes);  ///< waits until there is room
    ~Share();
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    void shrink(std::uint64_t bytes);  ///< gives back what is above `bytes`
    void settle(std::uint64_t bytes);  ///< the job is done and only its result of `bytes` stays: another may come in beside it

   private:
    MemoryGate& gate_;
    std::uint64_t bytes_;
    bool active_ = true;
  };

  std::uint64_t limit() const { return limit_; }

 private:
  const std::uint64_t limit_;
  std::mutex mutex_;
  std::condition_variable freed_;
  std::uint64_t held_ = 0;
  int active_ = 0;
};

}  // namespace overcast
