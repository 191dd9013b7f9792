// An arena of TBB for one evaluation.
#pragma once

#include <tbb/task_arena.h>

#include <memory>

namespace terrazzo {

// Takes an arena of `threads` threads (at least 1) that no other evaluation uses, and leaves it to later
// ones. TBB 2021.8 never frees some 8 kB of an arena in which its workers ran, so an arena for each
// evaluation would make a process grow without limit.
class Arena {
 public:
  explicit Arena(int threads);
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  tbb::task_arena* operator->() { return arena_.get(); }

 private:
  int threads_;
  std::unique_ptr<tbb::task_arena> arena_;
};

}  // namespace terrazzo
