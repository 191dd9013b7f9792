// The command line: parses it, runs one command, returns the exit code (INTERFACE: 0, 1, 2, 130).
#pragma once

#include "graph/registry.h"
#include "runtime/value.h"

namespace terrazzo {

int run_command_line(int argc, char** argv, const Registry&, const ValueTypes&);

}  // namespace terrazzo
