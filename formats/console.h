// Console: what the commands say on stdout and stderr. A stream that is full, broken or closed never ends a job, and a result that nobody
// received never counts as success.
#pragma once

#include <string>
#include <string_view>

#include "formats/result.h"

namespace overcast {

/// `text` with a space for every control character: names come from files, and neither a line break nor an escape sequence in them may
/// reach the terminal.
std::string oneLine(std::string text);

/// First thing in main: opens /dev/null in the place of each of stdin, stdout and stderr that the caller closed. Else the next file that is
/// opened takes its number, and what is meant for the user goes into that file.
void holdStandardStreams();

/// Appends to stdout. What cannot be written shows in flushResults.
void printResult(std::string_view text);

/// Writes to stderr at once. When that fails there is nobody to tell.
void printMessage(std::string_view text);

/// Writes what is left for stdout. An Error when any of it, or any earlier part, could not be written.
Result<Done> flushResults();

}  // namespace overcast
