// Shell: runs a command line as a user would and keeps what it said.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include <fmt/format.h>

namespace overcast::test {

struct ShellResult {
  int exitCode = -1;  ///< 128 + signal when a signal ended it
  std::string output;
};

/// One word of a shell command.
inline std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) {
    if (c == '\'') text += "'\\'";
    text += c;
  }
  text += '\'';
  return text;
}

/// Runs `command` in `folder` without standard input; stdout and stderr together unless the command says otherwise.
inline ShellResult shell(const std::string& command, const std::filesystem::path& folder = std::filesystem::temp_directory_path()) {
  ShellResult result;
  FILE* pipe = popen(fmt::format("cd {} && {{ {}; }} 2>&1 < /dev/null", quoted(folder.string()), command).c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> chunk{};
  while (const std::size_t count = std::fread(chunk.data(), 1, chunk.size(), pipe)) result.output.append(chunk.data(), count);
  const int status = pclose(pipe);
  result.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace overcast::test
