// overcast-player cost [-o FILE]
#pragma once

namespace overcast {

/// Measures the composite costs of a device and prints or writes them; the arguments are those behind "cost". Returns an ExitCode.
int costCommand(int argc, char** argv);

}  // namespace overcast
