// overcast-player report SCENE... -o FOLDER, and overcast-player compare BEFORE.json AFTER.json
#pragma once

namespace overcast {

/// Measures error, time and memory of every setting on scenes and writes a report; the arguments are those behind "report". Returns an
/// ExitCode.
int reportCommand(int argc, char** argv);

/// Prints what changed between two reports; the arguments are those behind "compare". Returns an ExitCode, unmet where anything got worse
/// beyond the noise that both state, or is gone.
int compareCommand(int argc, char** argv);

}  // namespace overcast
