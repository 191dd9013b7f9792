// Room for threads under a limit of the address space (ulimit -v).
#pragma once

namespace terrazzo {

// Throws Error "no-memory" if the rest of the limit is too small for so many new threads. If one cannot be
// created, TBB ends the process or waits forever.
void require_room_for_threads(int threads);

}  // namespace terrazzo
