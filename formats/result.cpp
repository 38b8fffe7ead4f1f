#include "formats/result.h"

#include <cstdio>

#include "formats/console.h"

namespace overcast {

std::string message(const Error& error) {
  std::string line = error.file;
  for (const std::string* part : {&error.place, &error.reason}) {
    if (part->empty()) continue;
    if (!line.empty()) line += ": ";
    line += *part;
  }
  return oneLine(std::move(line));
}

void stop(const char* file, int line, const std::string& what) {
  std::fprintf(stderr, "%s:%d: %s\n", file, line, what.c_str());
  std::abort();
}

}  // namespace overcast
