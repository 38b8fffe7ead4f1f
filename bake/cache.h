// Cache: a folder of results named by the hash of everything they depend on, in the manner of ccache. Several processes may share it; it
// may be deleted, cut down or damaged at any time and only costs bakes.
//
// In DIR/v1/: `entries` are small records under a key that the caller makes, `objects` are file contents under their own content hash.
// Both carry hashes that are checked when they are read: what is torn or altered counts as missing, is removed, and is noted.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "formats/result.h"

namespace overcast {

/// Bytes that a cache may take unless told otherwise.
inline constexpr std::uint64_t kDefaultCacheLimit = std::uint64_t{5} << 30;

enum class CacheUse { readWrite, readOnly };

/// All functions may be called from any thread.
class Cache {
 public:
  using Bytes = std::vector<std::byte>;

  /// `limit` bytes at most after trim. An Error when the folder cannot be made or written; read-only ones need not exist.
  static Result<std::unique_ptr<Cache>> open(const std::filesystem::path& folder, std::uint64_t limit, CacheUse use = CacheUse::readWrite);
  ~Cache();  ///< trims when anything was stored
  Cache(const Cache&) = delete;
  Cache& operator=(const Cache&) = delete;

  /// What was stored under the key (32 hexadecimal digits); nothing when there is none or it is damaged. Marks it as just used.
  std::optional<Bytes> entry(const std::string& key);
  /// The content with this hash (formats/files.h) and size, likewise.
  std::optional<Bytes> object(const std::string& hash, std::uint64_t size);

  /// Keeps what was made. A full disk costs a note and the entry. Objects go before the entries that name them.
  void storeEntry(const std::string& key, std::span<const std::byte> payload);
  void storeObject(const std::string& hash, std::span<const std::byte> bytes);

  /// Removes what was not used for the longest time until a tenth below the limit, when above it: objects first, because an entry still
  /// tells that outputs on disk are up to date. Also what killed processes left half-written over an hour ago.
  void trim();

  /// What the user should know since the last call, one line each.
  std::vector<std::string> takeNotes();

 private:
  Cache(std::filesystem::path folder, std::uint64_t limit, CacheUse use);
  std::optional<Bytes> fetch(const std::filesystem::path& file);
  void store(const std::filesystem::path& file, std::span<const std::byte> bytes);
  void discard(const std::filesystem::path& file);
  void note(std::string text);

  const std::filesystem::path folder_;  ///< DIR/v1
  const std::uint64_t limit_;
  const CacheUse use_;
  std::atomic<std::uint64_t> untrimmed_{0};  ///< bytes stored since the last trim
  std::mutex trimming_;
  std::mutex noting_;
  std::vector<std::string> notes_;
  bool storeFailed_ = false;
};

/// Keys that threads of this process are working on: who wants one that is taken waits, and then finds its result in the cache.
class KeyLocks {
 public:
  /// Holds a key until it is destroyed.
  class Lock {
   public:
    Lock(KeyLocks& locks, std::string key);
    ~Lock();
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;

   private:
    KeyLocks& locks_;
    std::string key_;
  };

 private:
  std::mutex mutex_;
  std::condition_variable released_;
  std::set<std::string> taken_;
};

/// Stands for this very program and the instruction sets it finds, which may round differently: others bake on their own.
const std::string& programHash();

}  // namespace overcast
