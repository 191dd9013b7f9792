// The files of the paint page, embedded at build time.
#pragma once

#include <string>

namespace terrazzo::studio {

// The content of the file with this name in page/, or null.
const char* page_file(const std::string& name);

}  // namespace terrazzo::studio
