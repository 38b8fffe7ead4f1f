// Command: what all commands of overcast-player have in common.
#pragma once

#include <functional>
#include <optional>

#include "formats/result.h"

namespace CLI {
class App;
}

namespace overcast {

/// Exit codes, as overcast-bake has them where they mean the same.
enum class ExitCode { ok = 0, internal = 1, usage = 2, unreadable = 3, unwritable = 4, noDevice = 5, unmet = 6 };

/// An Error and the exit code it ends the command with.
struct Failure {
  Error error;
  ExitCode code = ExitCode::internal;
};

/// Says in one line what went wrong; the exit code.
int fail(const Error& error, ExitCode code);
int fail(const Failure& failure);

/// Parses the command line into what `app` was told; then `check`, which may throw CLI::ParseError, looks at what spans several options.
/// The exit code when there is nothing to do any more: help was shown, or a usage error reported.
std::optional<int> parseArguments(
    CLI::App& app, int argc, char** argv, const std::function<void()>& check = [] {});

}  // namespace overcast
