// The manual page terrazzo(1), made from the declarations of the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace terrazzo::cli {

// The page as roff with man(7) macros. `app`: the program with all its commands.
std::string manual(const CLI::App& app);

}  // namespace terrazzo::cli
