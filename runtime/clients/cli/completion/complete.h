// Shell completion: candidates for the last word of a command line.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "runtime/clients/cli/command_line.h"

namespace terrazzo::cli {

// The words to complete `words.back()` to, given the words before it, without the program's name. Folders end
// in '/', and names that need a value end in '='. Loads node types only if the candidates depend on them.
std::vector<std::string> complete(const CLI::App&, const Program&, const std::vector<std::string>& words);

// `terrazzo complete -- WORD...`, which the completion scripts call: prints the candidates, one per line.
// Prints no errors: without candidates, it prints nothing.
int print_completions(const CLI::App&, const Program&, std::vector<std::string> words);

}  // namespace terrazzo::cli
