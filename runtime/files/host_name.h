// The name of this machine.
#pragma once

#include <string>

namespace terrazzo {

// At most 24 letters, digits and hyphens; "host" if the system gives no name.
const std::string& host_name();

}  // namespace terrazzo
