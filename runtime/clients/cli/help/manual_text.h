// The parts of the manual that are not declared by the command line, as roff.
#pragma once

#include <string>

namespace terrazzo::cli {

std::string manual_description();
// Exit status, environment, files, examples and references.
std::string manual_end();

}  // namespace terrazzo::cli
