// The page's files, embedded when the program is built.
#pragma once

#include <string>

namespace terrazzo::studio {

// The text of a file of page/ by name, or null.
const char* page_file(const std::string& name);

}  // namespace terrazzo::studio
