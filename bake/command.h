// Commands of overcast-bake: what each takes, and the exit codes they share.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "formats/result.h"

namespace CLI {
class App;
}

namespace overcast {

/// Exit codes, the same for every command; `--help` and the README list them.
enum ExitCode : int {
  kOk = 0,
  kInternal = 1,     ///< a fault of ours, or memory ran out
  kUsage = 2,        ///< wrong arguments
  kBadInput = 3,     ///< an input that cannot be read or baked; nothing was written
  kCannotWrite = 4,  ///< the output, or what belongs on stdout, cannot be written
  kNotValid = 5,     ///< `validate` or `verify` found something
  kPartial = 6,      ///< --keep-going: some inputs failed, the others were baked
  kInterrupted = 130
};

/// The paragraph about exit codes at the end of every --help.
extern const char* const kExitCodeHelp;

/// One command: main.cpp has the table.
struct Command {
  const char* name;
  const char* summary;                                    ///< one line
  int (*run)(const std::vector<std::string>& arguments);  ///< without program and command name; returns an ExitCode
};

/// Parses `arguments`; when something else than running the command is to be done (help asked for, a mistake), does it and returns the
/// exit code, else -1.
int parseArguments(CLI::App& app, const std::vector<std::string>& arguments);

/// Checks of options, as CLI11 wants them: why `text` is not a positive (and finite) number, or not one within [least, most]; empty when it
/// is. CLI11's own let "nan" pass.
std::string positiveNumber(const std::string& text);
std::function<std::string(const std::string&)> numberWithin(double least, double most);

/// "overcast-bake: <message>" on stderr.
void complain(const Error& error);

/// From now on the first SIGINT or SIGTERM only makes `interrupted` true; the second one ends the process at once.
void watchInterrupts();
bool interrupted();

}  // namespace overcast
