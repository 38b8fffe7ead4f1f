// Why forking a process that has threads is acceptable here: after fork the child has only the calling thread. POSIX promises it
// async-signal-safe calls only, but glibc keeps malloc, stdio and the unwinder usable across fork, and a parser needs nothing else that
// another thread could have held locked. TBB is the exception (OpenVDB frees trees with it): work shared with threads that the child does
// not have is never finished, so the child parses in an arena of one slot that was made before the fork. Should a lock be inherited all the
// same, the child hangs, is killed at the wall-clock limit and costs one file. The child touches neither the threads nor the Vulkan device
// it inherits and leaves with _exit, so no destructor of the parent's objects runs twice.
#include "formats/sandbox.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include <tbb/task_arena.h>

namespace overcast {
namespace {

using Clock = std::chrono::steady_clock;
using Bytes = std::vector<std::byte>;

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kAddressSanitizer = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr bool kAddressSanitizer = true;
#else
constexpr bool kAddressSanitizer = false;
#endif
#else
constexpr bool kAddressSanitizer = false;
#endif

enum class Outcome : std::uint32_t { value, error, outOfMemory, exception };

/// What the child sends first; `bytes` bytes of payload follow: the value, or the text of the error.
struct Header {
  std::uint32_t magic = 0;
  Outcome outcome = Outcome::value;
  std::uint64_t bytes = 0;
};
constexpr std::uint32_t kMagic = 0x4f564331;  // "OVC1"

/// The bytes of address space that this process has mapped.
std::uint64_t mappedBytes() {
  std::FILE* file = std::fopen("/proc/self/statm", "re");
  if (file == nullptr) return 0;
  unsigned long pages = 0;
  const int got = std::fscanf(file, "%lu", &pages);
  std::fclose(file);
  return got == 1 ? std::uint64_t{pages} * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

void limit(__rlimit_resource resource, std::uint64_t value) {
  rlimit current{};
  ::getrlimit(resource, &current);
  const rlim_t bound = std::min<rlim_t>(value, current.rlim_max);
  const rlimit lowered{bound, bound};
  ::setrlimit(resource, &lowered);
}

/// Signals, descriptors and limits of the child. Handlers of the parent must not run here, and nothing may reach its terminal.
void enterSandbox(const SandboxLimits& limits, int resultPipe, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);  // the parent died before the line above
  struct sigaction defaultAction {};
  defaultAction.sa_handler = SIG_DFL;
  for (int signal = 1; signal < NSIG; ++signal) ::sigaction(signal, &defaultAction, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  sigset_t none{};
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);

  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nowhere < 0) ::_exit(1);
  for (int fd = 0; fd <= 2; ++fd) ::dup2(nowhere, fd);
  // The pipes of other sandboxes must not stay open here: their parents wait for the end of file.
  if (resultPipe > 3) ::close_range(3, static_cast<unsigned>(resultPipe - 1), 0);
  ::close_range(static_cast<unsigned>(resultPipe + 1), ~0u, 0);

  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, static_cast<std::uint64_t>(limits.wallTime.count()) / 1000 + 2);
  // AddressSanitizer maps terabytes of shadow memory; its builds go without this limit.
  if (!kAddressSanitizer) limit(RLIMIT_AS, mappedBytes() + limits.memoryBytes);
}

bool sendAll(int fd, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(fd, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

void send(int fd, Outcome outcome, const void* data, std::size_t size) {
  const Header header{kMagic, outcome, size};
  if (sendAll(fd, &header, sizeof header)) sendAll(fd, data, size);
}

/// An Error as three strings, each ended by a zero byte.
std::string packed(const Error& error) {
  return error.file + '\0' + error.place + '\0' + error.reason + '\0';
}

Error unpacked(const Bytes& bytes) {
  std::array<std::string, 3> parts;
  std::size_t part = 0;
  for (const std::byte b : bytes) {
    const char c = static_cast<char>(b);
    if (c == '\0' && ++part == parts.size()) break;
    if (c != '\0') parts[part] += c;
  }
  return Error{parts[0], parts[1], parts[2]};
}

[[noreturn]] void runChild(const SandboxLimits& limits, int resultPipe, pid_t parent, tbb::task_arena& alone,
                           const std::function<Result<Bytes>()>& parse) {
  enterSandbox(limits, resultPipe, parent);
  try {
    const Result<Bytes> result = alone.execute(parse);
    if (result) {
      send(resultPipe, Outcome::value, result.value().data(), result.value().size());
    } else {
      const std::string text = packed(result.error());
      send(resultPipe, Outcome::error, text.data(), text.size());
    }
  } catch (const std::bad_alloc&) {
    send(resultPipe, Outcome::outOfMemory, nullptr, 0);
  } catch (const std::length_error&) {
    send(resultPipe, Outcome::outOfMemory, nullptr, 0);  // a container asked for more than any memory
  } catch (const std::exception& thrown) {
    send(resultPipe, Outcome::exception, thrown.what(), std::strlen(thrown.what()));
  } catch (...) {
    send(resultPipe, Outcome::exception, nullptr, 0);
  }
  ::_exit(0);
}

enum class Received { all, end, late };

/// Reads exactly `size` bytes unless the child closes its end or the deadline passes first.
Received receive(int fd, void* data, std::size_t size, Clock::time_point deadline) {
  char* at = static_cast<char*>(data);
  while (size > 0) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return Received::late;
    pollfd waiting{fd, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(std::min<long long>(left, 1 << 30)));
    if (ready <= 0) continue;  // a signal, or time to look at the clock again
    const ssize_t got = ::read(fd, at, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return Received::end;
    at += got;
    size -= static_cast<std::size_t>(got);
  }
  return Received::all;
}

/// Ends the child if it still runs, collects it, and says how it ended.
int collect(pid_t child) {
  ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 32; }, ' ');
  return text;
}

std::string tooLate(const SandboxLimits& limits) {
  return fmt::format("reader took longer than {} s", static_cast<double>(limits.wallTime.count()) / 1000.0);
}

std::string tooMuchMemory(const SandboxLimits& limits) {
  return fmt::format("reading it needs more than {} MB of memory", limits.memoryBytes >> 20);
}

/// Why a child that sent no whole answer ended.
std::string deathReason(int status, const SandboxLimits& limits) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) return tooLate(limits);
  if (WIFSIGNALED(status)) return fmt::format("reader crashed (signal {})", WTERMSIG(status));
  return fmt::format("reader ended without an answer (exit code {})", WEXITSTATUS(status));
}

/// Waits a moment for a child that closed its pipe, so that its own end is seen and not our kill.
std::optional<int> endedByItself(pid_t child, Clock::time_point deadline) {
  int status = 0;
  while (Clock::now() < deadline) {
    const pid_t got = ::waitpid(child, &status, WNOHANG);
    if (got == child) return status;
    if (got < 0 && errno != EINTR) return 0;
    ::usleep(1000);
  }
  return std::nullopt;
}

Result<Bytes> answer(const std::filesystem::path& file, const SandboxLimits& limits, const Header& header, Bytes payload) {
  const auto fail = [&](std::string reason) { return Error{file.string(), "", std::move(reason)}; };
  if (header.outcome == Outcome::value) return payload;
  if (header.outcome == Outcome::outOfMemory) return fail(tooMuchMemory(limits));
  const std::string text(reinterpret_cast<const char*>(payload.data()), payload.size());
  if (header.outcome == Outcome::exception) return fail(oneLine(fmt::format("reader gave up: {}", text)));
  Error error = unpacked(payload);
  if (error.file.empty()) error.file = file.string();
  return error;
}

Result<Bytes> hearChild(const std::filesystem::path& file, const SandboxLimits& limits, int pipe, pid_t child) {
  const auto fail = [&](std::string reason) { return Error{file.string(), "", std::move(reason)}; };
  const Clock::time_point deadline = Clock::now() + limits.wallTime;
  Header header;
  Bytes payload;
  Received received = receive(pipe, &header, sizeof header, deadline);
  if (received == Received::all) {
    if (header.magic != kMagic || header.bytes > limits.resultBytes) {
      collect(child);
      return fail(header.magic != kMagic ? "reader answered nonsense"
                                         : fmt::format("holds more than the {} MB accepted", limits.resultBytes >> 20));
    }
    payload.resize(header.bytes);
    received = receive(pipe, payload.data(), payload.size(), deadline);
  }
  if (received == Received::end) {
    const std::optional<int> status = endedByItself(child, deadline);
    if (status) return fail(deathReason(*status, limits));
    received = Received::late;
  }
  collect(child);
  if (received == Received::late) return fail(tooLate(limits));
  return answer(file, limits, header, std::move(payload));
}

}  // namespace

Result<Bytes> runSandboxed(const std::filesystem::path& file, const SandboxLimits& limits, const std::function<Result<Bytes>()>& parse) {
  std::array<int, 2> pipe{-1, -1};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) return Error{file.string(), "", fmt::format("cannot start a reader: {}", std::strerror(errno))};
  tbb::task_arena alone(1);
  alone.execute([] {});  // this thread and the arena are known to TBB before the fork
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) runChild(limits, pipe[1], parent, alone, parse);
  ::close(pipe[1]);
  if (child < 0) {
    ::close(pipe[0]);
    return Error{file.string(), "", fmt::format("cannot start a reader: {}", std::strerror(errno))};
  }
  Result<Bytes> result = hearChild(file, limits, pipe[0], child);
  ::close(pipe[0]);
  return result;
}

}  // namespace overcast
