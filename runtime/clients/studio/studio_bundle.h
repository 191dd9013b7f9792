// The script of the Studio's page, compressed with gzip. Empty if the program was built without it.
#pragma once

#include <string_view>

namespace terrazzo::studio {

std::string_view studio_bundle();

}  // namespace terrazzo::studio
