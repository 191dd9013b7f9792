// Shell completion of an option's value or of an argument.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "runtime/clients/cli/command_line.h"

namespace terrazzo::cli {

// Candidates for a value that begins with `typed`; some may not begin with it. `graph`: the graph file on the
// command line, or "".
std::vector<std::string> complete_value(const Program&, const CLI::Option&, const std::string& graph,
                                        const std::string& typed);

}  // namespace terrazzo::cli
