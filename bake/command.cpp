#include "bake/command.h"

#include <cmath>
#include <csignal>

#include <CLI/CLI.hpp>

#include "formats/console.h"

namespace overcast {
namespace {

volatile std::sig_atomic_t stopRequested = 0;

void requestStop(int) {
  stopRequested = 1;
}

}  // namespace

const char* const kExitCodeHelp =
    "Exit codes: 0 done; 1 internal error; 2 wrong arguments or config; 3 an input cannot be read or baked (nothing was written);\n"
    "4 the output cannot be written; 5 validate or verify found something; 6 some inputs failed (--keep-going, --each); 130 interrupted.\n"
    "Results go to stdout, messages to stderr.";

int parseArguments(CLI::App& app, const std::vector<std::string>& arguments) {
  app.footer(kExitCodeHelp);
  try {
    // CLI11 takes the arguments from the back.
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::Success& success) {
    app.exit(success);
    return kOk;
  } catch (const CLI::ParseError& mistake) {
    complain(Error{"", "", fmt::format("{} (see --help)", mistake.what())});
    return kUsage;
  }
  return -1;
}

std::string positiveNumber(const std::string& text) {
  double number = 0.0;
  if (CLI::detail::lexical_cast(text, number) && std::isfinite(number) && number > 0.0) return "";
  return fmt::format("'{}' is not a positive number", text);
}

std::function<std::string(const std::string&)> numberWithin(double least, double most) {
  return [=](const std::string& text) -> std::string {
    double number = 0.0;
    if (CLI::detail::lexical_cast(text, number) && number >= least && number <= most) return "";
    return fmt::format("'{}' is not a number from {} to {}", text, least, most);
  };
}

void complain(const Error& error) {
  printMessage(fmt::format("overcast-bake: {}\n", message(error)));
}

void watchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = requestStop;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() {
  return stopRequested != 0;
}

}  // namespace overcast
