#include "runtime/threads/arena.h"

#include <map>
#include <mutex>
#include <vector>

#include "graph/numeric_environment.h"

namespace terrazzo {
namespace {

struct Idle {
  std::mutex mutex;
  std::map<int, std::vector<std::unique_ptr<tbb::task_arena>>> by_threads;
};

// Never destroyed: an evaluation may end after static variables are.
Idle& idle() {
  static auto& all = *new Idle;
  return all;
}

}  // namespace

Arena::Arena(int threads) : threads_(threads) {
  {
    const std::lock_guard lock(idle().mutex);
    auto& list = idle().by_threads[threads];
    if (!list.empty()) {
      arena_ = std::move(list.back());
      list.pop_back();
    }
  }
  if (!arena_) {
    const NumericEnvironment numbers;  // which its threads and their loops get
    arena_ = std::make_unique<tbb::task_arena>();
    arena_->initialize(threads);
  }
}

Arena::~Arena() {
  const std::lock_guard lock(idle().mutex);
  idle().by_threads[threads_].push_back(std::move(arena_));
}

}  // namespace terrazzo
