// overcast-player measure PICTURE REFERENCE [--frames A:B] [--channels NAMES] [--flip FILE] [--json]
#pragma once

namespace overcast {

/// Measures pictures against references and prints every metric; the arguments are those behind "measure". Returns an ExitCode.
int measureCommand(int argc, char** argv);

}  // namespace overcast
