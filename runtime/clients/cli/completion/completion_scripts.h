// The completion scripts in shells/, which CMake embeds in the program.
#pragma once

#include <string>

namespace terrazzo::cli {

// The text of a script such as "terrazzo.bash", or null.
const char* completion_script(const std::string& name);

}  // namespace terrazzo::cli
