// The plan of which file operations of a process fail. The library of fault_shim.cpp applies it. It is either
// preloaded into a program (LD_PRELOAD, with the plan in the environment) or linked to one that calls
// terrazzo_begin_faults.
#pragma once

#include <atomic>
#include <cstdint>

namespace terrazzo::torture {

enum FaultOperation : unsigned {
  open_to_read = 1,
  open_to_write = 2,
  write_bytes = 4,  // write, pwrite, writev, fwrite
  sync_file = 8,    // fsync, fdatasync
  rename_file = 16,
  make_folder = 32,
  close_stream = 64,  // fflush, fclose: buffered data is lost
  all_operations = 127
};

struct FaultPlan {
  std::uint64_t seed = 1;
  double rate = 0;               // share of calls that fail
  unsigned operations = 0;       // operations that may fail
  std::uint64_t full_after = 0;  // from this call on, writes fail as on a full disk; 0: never
  bool passing = false;          // only interruptions and short counts, which a retry overcomes
  char folder[512] = {};         // only files below this folder fail
};

struct FaultCounts {
  std::atomic<std::uint64_t> calls{0}, injected{0};
};

}  // namespace terrazzo::torture

// Activates the plan in this process. `counts` may be in memory shared with another process.
extern "C" void terrazzo_begin_faults(const terrazzo::torture::FaultPlan*,
                                      terrazzo::torture::FaultCounts* counts);
