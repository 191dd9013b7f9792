// Runs another program and collects what it prints.
#pragma once

#include <string>
#include <vector>

namespace terrazzo {

struct Subprocess {
  int exit_code = -1;  // 128 + the signal if a signal ended it; 127 if the program was not found
  std::string out, err;
};
// `command`: the program, searched in PATH if it has no slash, and its arguments. Waits for its end. Throws
// Error "no-program" if it cannot be started.
Subprocess run_subprocess(const std::vector<std::string>& command);

}  // namespace terrazzo
