#include "runtime/player/command.h"

#include <CLI/CLI.hpp>

#include "formats/console.h"

namespace overcast {

int fail(const Error& error, ExitCode code) {
  printMessage(fmt::format("overcast-player: {}\n", message(error)));
  return static_cast<int>(code);
}

int fail(const Failure& failure) {
  return fail(failure.error, failure.code);
}

std::optional<int> parseArguments(CLI::App& app, int argc, char** argv, const std::function<void()>& check) {
  try {
    app.parse(argc, argv);
    check();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      app.exit(error);
      return static_cast<int>(ExitCode::ok);
    }
    printMessage(oneLine(fmt::format("overcast-player: {} (see --help)", error.what())) + "\n");
    return static_cast<int>(ExitCode::usage);
  }
  return std::nullopt;
}

}  // namespace overcast
