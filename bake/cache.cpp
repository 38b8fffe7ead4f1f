#include "bake/cache.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <system_error>

#include "formats/files.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "v1";  // raise it when entries or their place change
constexpr const char* kTag =           // https://bford.info/cachedir: backups leave the folder out
    "Signature: 8a477f597d28d172789f06886806bc55\n# Results that overcast-bake can make again. May be deleted at any time.\n";
constexpr std::size_t kHashDigits = 32;
constexpr std::chrono::hours kHalfWrittenAge{1};

/// "ab/cdef..." below entries or objects.
fs::path placeOf(const char* kind, const std::string& hash) {
  return fs::path(kind) / hash.substr(0, 2) / hash.substr(2);
}

/// Tells entries that were moved to another key from whole ones.
std::string sealOf(const std::string& key, std::span<const std::byte> payload) {
  const std::string text = key + contentHash(payload);
  return contentHash(std::as_bytes(std::span(text)));
}

void markUsed(const fs::path& file) {
  ::utimensat(AT_FDCWD, file.c_str(), nullptr, 0);
}

struct Stored {
  fs::path path;
  std::uint64_t bytes = 0;
  fs::file_time_type used;
  bool entry = false;
};

/// Every whole file below `folder`; removes what others left half-written.
std::vector<Stored> list(const fs::path& folder) {
  std::vector<Stored> files;
  std::error_code code;
  for (const char* kind : {"entries", "objects"}) {
    for (fs::recursive_directory_iterator at(folder / kind, code), end; !code && at != end; at.increment(code)) {
      std::error_code gone;  // another process may trim too
      if (!at->is_regular_file(gone) || gone) continue;
      Stored file{at->path(), at->file_size(gone), {}, std::strcmp(kind, "entries") == 0};
      if (!gone) file.used = at->last_write_time(gone);
      if (gone) continue;
      if (file.path.extension() != ".tmp")
        files.push_back(std::move(file));
      else if (fs::file_time_type::clock::now() - file.used > kHalfWrittenAge)
        fs::remove(file.path, gone);
    }
    code.clear();
  }
  return files;
}

}  // namespace

Cache::Cache(fs::path folder, std::uint64_t limit, CacheUse use) : folder_(std::move(folder)), limit_(limit), use_(use) {}

Cache::~Cache() {
  if (untrimmed_ > 0) trim();
}

Result<std::unique_ptr<Cache>> Cache::open(const fs::path& folder, std::uint64_t limit, CacheUse use) {
  std::error_code code;
  if (fs::exists(folder, code) && !fs::is_directory(folder, code)) return Error{folder.string(), "", "is not a folder"};
  if (use == CacheUse::readWrite) {
    fs::create_directories(folder / kFormat, code);
    if (const auto writable = checkWritable(folder / kFormat); !writable) return Error{folder.string(), "", writable.error().reason};
    const std::string_view tag = kTag;
    if (!fs::exists(folder / "CACHEDIR.TAG", code))
      if (const auto written = writeFileAtomically(folder / "CACHEDIR.TAG", std::as_bytes(std::span(tag)), Durability::unsynced); !written)
        return written.error();
  }
  return std::unique_ptr<Cache>(new Cache(folder / kFormat, limit, use));
}

std::optional<Cache::Bytes> Cache::fetch(const fs::path& file) {
  std::error_code code;
  if (!fs::exists(file, code)) return std::nullopt;
  auto bytes = readFile(file);
  if (!bytes) return std::nullopt;
  return std::move(bytes).value();
}

std::optional<Cache::Bytes> Cache::entry(const std::string& key) {
  const fs::path file = folder_ / placeOf("entries", key);
  std::optional<Bytes> bytes = fetch(file);
  if (!bytes) return std::nullopt;
  const std::span<const std::byte> payload = std::span(*bytes).subspan(std::min(bytes->size(), kHashDigits));
  const std::string seal = sealOf(key, payload);
  if (bytes->size() < kHashDigits || std::memcmp(bytes->data(), seal.data(), kHashDigits) != 0) {
    discard(file);
    return std::nullopt;
  }
  if (use_ == CacheUse::readWrite) markUsed(file);
  bytes->erase(bytes->begin(), bytes->begin() + kHashDigits);
  return bytes;
}

std::optional<Cache::Bytes> Cache::object(const std::string& hash, std::uint64_t size) {
  const fs::path file = folder_ / placeOf("objects", hash);
  std::optional<Bytes> bytes = fetch(file);
  if (!bytes) return std::nullopt;
  if (bytes->size() != size || contentHash(*bytes) != hash) {
    discard(file);
    return std::nullopt;
  }
  if (use_ == CacheUse::readWrite) markUsed(file);
  return bytes;
}

void Cache::storeEntry(const std::string& key, std::span<const std::byte> payload) {
  const std::string seal = sealOf(key, payload);
  const auto sealed = std::as_bytes(std::span(seal));
  Bytes bytes(sealed.begin(), sealed.end());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  store(folder_ / placeOf("entries", key), bytes);
}

void Cache::storeObject(const std::string& hash, std::span<const std::byte> bytes) {
  const fs::path file = folder_ / placeOf("objects", hash);
  std::error_code code;
  if (fs::file_size(file, code) == bytes.size() && !code)
    markUsed(file);
  else
    store(file, bytes);
}

void Cache::store(const fs::path& file, std::span<const std::byte> bytes) {
  if (use_ == CacheUse::readOnly) return;
  // Unsynced: what a power failure tears is found by its hash.
  const auto written = writeFileAtomically(file, bytes, Durability::unsynced);
  if (!written) {
    const std::lock_guard lock(noting_);
    if (!storeFailed_) notes_.push_back(fmt::format("cache: {}; results are not kept", message(written.error())));
    storeFailed_ = true;
    return;
  }
  untrimmed_ += bytes.size();
  if (untrimmed_ > limit_ / 8) trim();
}

void Cache::discard(const fs::path& file) {
  note(fmt::format("cache: {} is damaged; baking again", file.string()));
  std::error_code code;
  if (use_ == CacheUse::readWrite) fs::remove(file, code);
}

void Cache::note(std::string text) {
  const std::lock_guard lock(noting_);
  notes_.push_back(std::move(text));
}

std::vector<std::string> Cache::takeNotes() {
  const std::lock_guard lock(noting_);
  return std::exchange(notes_, {});
}

void Cache::trim() {
  const std::unique_lock lock(trimming_, std::try_to_lock);
  if (!lock) return;
  untrimmed_ = 0;
  std::vector<Stored> files = list(folder_);
  std::uint64_t total = 0;
  for (const Stored& file : files) total += file.bytes;
  if (total <= limit_) return;
  std::sort(files.begin(), files.end(), [](const Stored& a, const Stored& b) {
    if (a.entry != b.entry) return b.entry;
    return a.used != b.used ? a.used < b.used : a.path < b.path;
  });
  for (const Stored& file : files) {
    if (total <= limit_ - limit_ / 10) break;
    std::error_code code;
    fs::remove(file.path, code);
    if (!code) total -= file.bytes;
  }
}

KeyLocks::Lock::Lock(KeyLocks& locks, std::string key) : locks_(locks), key_(std::move(key)) {
  std::unique_lock lock(locks_.mutex_);
  locks_.released_.wait(lock, [&] { return locks_.taken_.insert(key_).second; });
}

KeyLocks::Lock::~Lock() {
  {
    const std::lock_guard lock(locks_.mutex_);
    locks_.taken_.erase(key_);
  }
  locks_.released_.notify_all();
}

const std::string& programHash() {
  static const std::string hash = [] {
    const auto program = readFile("/proc/self/exe");
    return fmt::format("{} {:d}{:d}", program ? contentHash(program.value()) : "", __builtin_cpu_supports("avx2") != 0,
                       __builtin_cpu_supports("avx512f") != 0);
  }();
  return hash;
}

}  // namespace overcast
