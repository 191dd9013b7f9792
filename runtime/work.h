// Work: the loops that nodes use. Parallelism, cancellation and progress live here so that no algorithm can
// forget them.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace terrazzo {

// A handle passed down into algorithms. Cheap to copy. Work() runs, is never cancelled and reports to nobody:
// what a unit test or a program without a graph passes.
class Work {
 public:
  using Report = std::function<void(double fraction, const std::string& note)>;

  Work() = default;
  // `also`: a second flag, for what stops this node alone.
  Work(const std::atomic<bool>* cancel, const Report* report, const std::atomic<bool>* also = nullptr)
      : cancel_(cancel), also_(also), report_(report) {}

  // Throws Cancelled once the user asked to stop. Call it at least every 50 ms in loops of your own.
  void check() const;
  bool cancelled() const { return set(cancel_) || set(also_); }

  // Tells how far this work is, 0 to 1, and what it is at ("overlap 0.03").
  void progress(double fraction, const std::string& note = {}) const;

  // The share [from, to] of this work's progress, for a stage of it.
  Work part(double from, double to) const;

  // The same loops and cancellation without reports: for the many short loops within one step of an
  // iteration.
  Work quiet() const {
    Work w = *this;
    w.report_ = nullptr;
    return w;
  }

  // Calls body(begin, end) for consecutive ranges of at most `grain` items of [0, n), on all threads of the
  // run. The ranges depend on n and grain alone, never on the number of threads. Checks for cancellation
  // before every range and reports progress.
  void parallel(std::size_t n, std::size_t grain,
                const std::function<void(std::size_t begin, std::size_t end)>& body) const;

  // map(begin, end) → T per range, then combined from left to right: the same bits for any number of threads.
  template <class T, class Map, class Combine>
  T reduce(std::size_t n, std::size_t grain, T start, Map&& map, Combine&& combine) const {
    std::vector<T> parts((n + grain - 1) / grain, start);
    parallel(n, grain, [&](std::size_t b, std::size_t e) { parts[b / grain] = map(b, e); });
    T total = std::move(start);
    for (auto& p : parts) total = combine(std::move(total), std::move(p));
    return total;
  }

 private:
  static bool set(const std::atomic<bool>* flag) { return flag && flag->load(std::memory_order_relaxed); }

  const std::atomic<bool>* cancel_ = nullptr;
  const std::atomic<bool>* also_ = nullptr;
  const Report* report_ = nullptr;
  double from_ = 0, to_ = 1;
};

}  // namespace terrazzo
