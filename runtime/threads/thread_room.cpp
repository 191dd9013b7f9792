#include "runtime/threads/thread_room.h"

#include <fmt/format.h>

#include <cstdint>

#include "graph/diagnostic.h"
#include "runtime/memory.h"

namespace terrazzo {

void require_room_for_threads(int threads) {
  constexpr std::uint64_t kOwn = 128'000'000, kPerThread = 16'000'000;
  const std::uint64_t needed = kOwn + kPerThread * threads;
  const std::uint64_t left = available_address_space();
  if (left < needed)
    throw Error("no-memory",
                fmt::format("not enough address space to start: {} MB left, but {} threads need {} MB",
                            left / 1'000'000, threads, needed / 1'000'000),
                "raise the limit (ulimit -v) or use fewer threads");
}

}  // namespace terrazzo
