// Sandbox: runs a parser of untrusted bytes in a child process with limits, so that a crash or a hang in a third-party reader
// costs one file and a clear error, never the batch.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "formats/result.h"

namespace overcast {

/// Limits of one sandboxed parse.
struct SandboxLimits {
  std::chrono::milliseconds wallTime{15000};              ///< wall-clock time before the child is killed
  std::uint64_t memoryBytes = std::uint64_t{1536} << 20;  ///< address space the child may take beyond what it inherits
  std::uint64_t resultBytes = std::uint64_t{1} << 30;     ///< largest result that is accepted
};

/// Runs `parse` in a forked child and returns the bytes it returned. A child that crashes, hangs, runs out of memory, or returns an Error
/// becomes an Error that names `file` and says which ("reader crashed (signal 11)", "reader took longer than 15 s", ...).
/// `parse` may use any library but must not start threads that it waits for by name, nor touch files other than its input.
/// The child writes nothing to stdout or stderr. Safe to call from several threads at once.
Result<std::vector<std::byte>> runSandboxed(const std::filesystem::path& file, const SandboxLimits& limits,
                                            const std::function<Result<std::vector<std::byte>>()>& parse);

}  // namespace overcast
