#include "formats/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>

#include "formats/uri.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

Error fileError(const fs::path& path, std::string reason) {
  return Error{path.string(), "", std::move(reason)};
}

/// The system's words for errno, in the lower case that Error::reason asks for.
std::string systemReason(int code) {
  std::string text = std::generic_category().message(code);
  if (!text.empty() && text[0] >= 'A' && text[0] <= 'Z') text[0] = static_cast<char>(text[0] - 'A' + 'a');
  return text;
}

/// An open file descriptor that closes itself.
struct Descriptor {
  int fd = -1;
  explicit Descriptor(int opened) : fd(opened) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  /// Closes now; false with errno when the system only now admits that data was lost (network file systems).
  bool close() { return ::close(std::exchange(fd, -1)) == 0; }
};

/// Removes the temporary file unless it was renamed.
struct TemporaryFile {
  fs::path path;
  bool keep = false;
  ~TemporaryFile() {
    if (!keep) ::unlink(path.c_str());
  }
};

int openRetrying(const fs::path& path, int flags, mode_t mode = 0) {
  int fd = -1;
  do fd = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  while (fd < 0 && errno == EINTR);
  return fd;
}

bool writeAll(int fd, std::span<const std::byte> bytes) {
  constexpr std::size_t kChunk = std::size_t{1} << 30;  // the kernel writes at most 2 GiB a call
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), std::min(bytes.size(), kChunk));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

/// A name beside `path` that no other writer, in this process or another, takes.
fs::path temporaryName(const fs::path& path) {
  static std::atomic<unsigned> serial{0};
  // A fixed-length prefix of the name: the file name itself may already be as long as the file system allows.
  const std::string stem = path.filename().string().substr(0, 64);
  return path.parent_path() / fmt::format(".{}.{}.{}.tmp", stem, ::getpid(), serial.fetch_add(1));
}

/// A new file beside `path`; its name is put in `name`.
int openTemporary(const fs::path& path, fs::path& name) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    name = temporaryName(path);
    const int fd = openRetrying(name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW, 0666);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
  return -1;
}

/// A new file in the folder of `path` that has no name yet, so that a killed process leaves nothing; -1 where the file system has no such.
int openNameless(const fs::path& path) {
  return openRetrying(path.parent_path().empty() ? fs::path(".") : path.parent_path(), O_WRONLY | O_TMPFILE, 0666);
}

/// Gives the nameless file this name, which nobody has.
bool nameFile(int fd, const fs::path& name) {
  return ::linkat(AT_FDCWD, fmt::format("/proc/self/fd/{}", fd).c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
}

/// A file that is written under no name or a temporary one and then takes the place of another. Removed unless it took it.
class PendingFile {
 public:
  explicit PendingFile(const fs::path& path) : path_(path), file_(openNameless(path)) {
    nameless_ = file_.fd >= 0;
    if (!nameless_) file_.fd = openTemporary(path, temporary_.path);
    temporary_.keep = nameless_ || file_.fd < 0;  // never created
  }

  int fd() const { return file_.fd; }

  /// Makes it the file at the path; false with errno when that fails.
  bool takePlace() {
    if (nameless_) {
      if (nameFile(file_.fd, path_)) return file_.close();
      if (errno != EEXIST || !nameTemporarily()) return false;
    }
    if (!file_.close() || ::rename(temporary_.path.c_str(), path_.c_str()) != 0) return false;
    temporary_.keep = true;
    return true;
  }

 private:
  bool nameTemporarily() {
    for (int attempt = 0; attempt < 100; ++attempt) {
      temporary_.path = temporaryName(path_);
      if (nameFile(file_.fd, temporary_.path)) {
        temporary_.keep = false;
        return true;
      }
      if (errno != EEXIST) return false;
    }
    return false;
  }

  const fs::path& path_;
  Descriptor file_;
  TemporaryFile temporary_;
  bool nameless_ = false;
};

Result<Done> syncFolder(const fs::path& path) {
  const fs::path folder = path.parent_path().empty() ? fs::path(".") : path.parent_path();
  const Descriptor opened(openRetrying(folder, O_RDONLY | O_DIRECTORY));
  // Some file systems cannot sync a folder (EINVAL); the rename itself has already happened.
  if (opened.fd < 0 || (::fsync(opened.fd) != 0 && errno != EINVAL)) {
    return fileError(path, fmt::format("written, but its folder could not be synced: {}", systemReason(errno)));
  }
  return Done{};
}

int openForReading(const fs::path& path) {
  // O_NONBLOCK: opening a named pipe must not wait for a writer.
  return openRetrying(path, O_RDONLY | O_NONBLOCK);
}

/// The size of an open file; an Error when it was not opened or is not a regular one.
Result<std::uint64_t> regularSize(const fs::path& path, const Descriptor& file) {
  struct stat status {};
  if (file.fd < 0 || ::fstat(file.fd, &status) != 0) return fileError(path, systemReason(errno));
  if (S_ISDIR(status.st_mode)) return fileError(path, "is a folder");
  if (!S_ISREG(status.st_mode)) return fileError(path, "is not a regular file");
  return static_cast<std::uint64_t>(status.st_size);
}

ssize_t readSome(const Descriptor& file, std::byte* to, std::size_t most) {
  ssize_t got = 0;
  do got = ::read(file.fd, to, most);
  while (got < 0 && errno == EINTR);
  return got;
}

std::string hexadecimal(const XXH128_hash_t& hash) {
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

Result<std::string> percentDecoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? hexDigit(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? hexDigit(text[i + 2]) : -1;
    if (high < 0 || low < 0) return Error{"", "", "has a % that is not followed by two hexadecimal digits"};
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return decoded;
}

bool hasScheme(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  return colon != std::string_view::npos && colon < uri.find('/');
}

}  // namespace

Result<std::vector<std::byte>> readFile(const fs::path& path, std::uint64_t maxBytes) {
  const Descriptor file(openForReading(path));
  const auto checked = regularSize(path, file);
  if (!checked) return checked.error();
  const std::uint64_t size = checked.value();
  if (size > maxBytes) return fileError(path, fmt::format("is {} bytes, more than the {} allowed", size, maxBytes));
  std::vector<std::byte> bytes(size);
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t got = readSome(file, bytes.data() + filled, bytes.size() - filled);
    if (got < 0) return fileError(path, systemReason(errno));
    if (got == 0) return fileError(path, "became shorter while it was read");
    filled += static_cast<std::size_t>(got);
  }
  return bytes;
}

Result<Done> writeFileAtomically(const fs::path& path, std::span<const std::byte> bytes, Durability durability) {
  if (!path.has_filename()) return fileError(path, "names no file");
  std::error_code failed;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), failed);
  if (failed) return fileError(path.parent_path(), fmt::format("cannot create the folder: {}", systemReason(failed.value())));

  PendingFile file(path);
  if (file.fd() < 0) return fileError(path, fmt::format("cannot be written: {}", systemReason(errno)));
  // A file that is replaced keeps its permissions.
  struct stat old {};
  if (::stat(path.c_str(), &old) == 0 && S_ISREG(old.st_mode) && ::fchmod(file.fd(), old.st_mode & 07777) != 0) {
    return fileError(path, fmt::format("cannot be written: {}", systemReason(errno)));
  }
  const bool synced = durability == Durability::synced;
  if (!writeAll(file.fd(), bytes) || (synced && ::fsync(file.fd()) != 0) || !file.takePlace())
    return fileError(path, fmt::format("cannot be written: {}", systemReason(errno)));
  return synced ? syncFolder(path) : Result<Done>(Done{});
}

Result<Done> writeFileAtomically(const fs::path& path, std::string_view text) {
  return writeFileAtomically(path, std::as_bytes(std::span(text.data(), text.size())));
}

Result<Done> checkWritable(const fs::path& folder) {
  std::error_code code;
  fs::path existing = folder.empty() ? fs::path(".") : fs::absolute(folder, code).lexically_normal();
  while (!fs::exists(existing, code) && existing.has_relative_path()) existing = existing.parent_path();
  if (!fs::is_directory(existing, code)) return fileError(fs::exists(folder, code) ? folder : existing, "is not a folder");
  // Asking by access() is not enough: it lets root write anywhere, read-only file systems included.
  if (PendingFile(existing / "overcast").fd() >= 0) return Done{};
  return fileError(folder, fmt::format("cannot be written: {}", systemReason(errno)));
}

std::string contentHash(std::span<const std::byte> bytes) {
  return hexadecimal(XXH3_128bits(bytes.data(), bytes.size()));
}

Result<std::string> fileHash(const fs::path& path) {
  const Descriptor file(openForReading(path));
  if (const auto checked = regularSize(path, file); !checked) return checked.error();
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<std::byte> chunk(std::size_t{1} << 18);
  while (const ssize_t got = readSome(file, chunk.data(), chunk.size())) {
    if (got < 0) return fileError(path, systemReason(errno));
    XXH3_128bits_update(state.get(), chunk.data(), static_cast<std::size_t>(got));
  }
  return hexadecimal(XXH3_128bits_digest(state.get()));
}

Result<fs::path> resolveInside(const fs::path& folder, std::string_view relative) {
  const auto refuse = [&](const std::string& reason) {
    std::string shown(relative.substr(0, 200));
    std::replace_if(
        shown.begin(), shown.end(), [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; }, '?');
    return Error{folder.string(), fmt::format("uri '{}'", shown), reason};
  };
  if (relative.empty()) return refuse("is empty");
  if (hasScheme(relative)) return refuse("has a scheme; only files beside the asset are read");
  const Result<std::string> decoded = percentDecoded(relative);
  if (!decoded) return refuse(decoded.error().reason);
  if (decoded.value().find('\0') != std::string::npos) return refuse("has a zero byte");
  if (decoded.value().find('\\') != std::string::npos) return refuse("has a backslash; folders are separated by /");
  const fs::path normal = fs::path(decoded.value()).lexically_normal();
  if (normal.is_absolute()) return refuse("is absolute; only files beside the asset are read");
  if (!normal.has_filename() || normal == ".") return refuse("names no file");
  if (*normal.begin() == "..") return refuse("leaves the folder of the asset");

  // A symbolic link below the folder may still lead out of it.
  std::error_code failed;
  const fs::path root = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, failed);
  if (failed) return refuse(systemReason(failed.value()));
  const fs::path target = fs::weakly_canonical(root / normal, failed);
  if (failed) return refuse(systemReason(failed.value()));
  const auto [rootEnd, targetRest] = std::mismatch(root.begin(), root.end(), target.begin(), target.end());
  if (rootEnd != root.end() || targetRest == target.end()) return refuse("leaves the folder of the asset");
  return folder / normal;
}

Result<std::filesystem::path> checkedFile(const std::filesystem::path& folder, std::string_view relative, const std::string& hash) {
  Result<std::filesystem::path> path = resolveInside(folder, uriFromPath(relative));
  if (!path) return path;
  const Result<std::string> found = fileHash(path.value());
  if (!found) return found.error();
  if (found.value() == hash) return path;
  return Error{path.value().string(), "",
               fmt::format("its content hash is {}, but the scene was baked with {}: bake the scene again", found.value(), hash)};
}

}  // namespace overcast
