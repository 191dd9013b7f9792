// The graph that `terrazzo run` evaluates if none is given.
#pragma once

#include <filesystem>
#include <string>

namespace terrazzo::cli {

// The material graph that is installed with this program, or that of the source tree if the program runs in
// its build folder. "" if neither exists.
std::filesystem::path default_graph();

// A graph that is installed with this program, such as "materials/texture_set.yaml". Throws Error "usage" if
// it is missing.
std::filesystem::path installed_graph(const std::string& name);

}  // namespace terrazzo::cli
