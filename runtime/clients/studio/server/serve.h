// Serves until the user interrupts the program.
#pragma once

#include <atomic>
#include <functional>

namespace terrazzo::studio {

// Calls `serve`, and `stop` from another thread once `cancel` is set.
void serve_until(const std::atomic<bool>& cancel, const std::function<void()>& serve,
                 const std::function<void()>& stop);

}  // namespace terrazzo::studio
