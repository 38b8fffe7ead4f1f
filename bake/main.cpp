// overcast-bake: the table of its commands.
#include <exception>
#include <new>

#include "bake/bake_command.h"
#include "bake/command.h"
#include "bake/explain_command.h"
#include "bake/inspect_command.h"
#include "bake/reference_command.h"
#include "bake/validate_command.h"
#include "bake/verify_command.h"
#include "formats/console.h"

namespace {

using namespace overcast;

constexpr Command kCommands[] = {
    {"bake", "bake meshes and scenes into a folder (the command when none is named)", bakeCommand},
    {"explain", "print what every representation of a mesh costs and how far off it is, and which one is chosen", explainCommand},
    {"inspect", "print what is in a baked scene, a plain scene, a mesh or a volume", inspectCommand},
    {"reference", "trace the truth that estimates are measured against: views and points of a scene, with standard errors",
     referenceCommand},
    {"validate", "check a baked scene or a volume: files, hashes, bounds, values", validateCommand},
    {"verify", "measure a baked scene again from its sources and compare with what it states", verifyCommand},
};

void printHelp() {
  printResult(
      "overcast-bake INPUT... -o FOLDER     bake meshes and scenes, see overcast-bake bake --help\n"
      "overcast-bake COMMAND ...            run a command, each has its own --help\n\nCommands:\n");
  for (const Command& command : kCommands) printResult(fmt::format("  {:10} {}\n", command.name, command.summary));
  printResult(fmt::format("  {:10} {}\n  {:10} {}\n\n{}\n", "--help", "this text", "--version", "the version", kExitCodeHelp));
}

int run(std::vector<std::string> arguments) {
  if (arguments.empty() || arguments[0] == "--help" || arguments[0] == "-h") {
    printHelp();
    return arguments.empty() ? kUsage : kOk;
  }
  if (arguments[0] == "--version") {
    printResult(fmt::format("overcast-bake {}\n", OVERCAST_VERSION));
    return kOk;
  }
  for (const Command& command : kCommands) {
    if (arguments[0] != command.name) continue;
    arguments.erase(arguments.begin());
    return command.run(arguments);
  }
  return bakeCommand(arguments);
}

}  // namespace

int main(int argc, char** argv) {
  holdStandardStreams();
  try {
    const int code = run(std::vector<std::string>(argv + 1, argv + argc));
    const auto flushed = flushResults();
    if (flushed) return code;
    complain(flushed.error());
    return code == kOk ? kCannotWrite : code;
  } catch (const std::bad_alloc&) {
    complain(Error{"", "", "out of memory"});
  } catch (const std::exception& problem) {
    complain(Error{"", "", fmt::format("internal error: {}", problem.what())});
  }
  return kInternal;
}
