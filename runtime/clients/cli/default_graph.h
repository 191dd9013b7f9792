// The graph that `terrazzo run` evaluates if none is given.
#pragma once

#include <filesystem>

namespace terrazzo::cli {

// The material graph that is installed with this program, or that of the source tree if the program runs in
// its build folder. "" if neither exists.
std::filesystem::path default_graph();

}  // namespace terrazzo::cli
