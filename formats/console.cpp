#include "formats/console.h"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace overcast {
namespace {

void put(std::string_view text, std::FILE* stream) {
  std::fwrite(text.data(), 1, text.size(), stream);
}

}  // namespace

std::string oneLine(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return text;
}

void holdStandardStreams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    // open takes the lowest free number, which is this one.
    if (::fcntl(stream, F_GETFD) < 0 && errno == EBADF && ::open("/dev/null", O_RDWR) < 0) return;
}

void printResult(std::string_view text) {
  put(text, stdout);
}

void printMessage(std::string_view text) {
  put(text, stderr);
  std::fflush(stderr);
}

Result<Done> flushResults() {
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0) return Done{};
  // An earlier failure has lost its reason.
  const std::string reason = errno != 0 ? std::generic_category().message(errno) : "an earlier part is lost";
  return Error{"stdout", "", fmt::format("cannot be written: {}", reason)};
}

}  // namespace overcast
