// Work: parallel loops for nodes, with built-in cancellation and progress, so that no algorithm can forget
// them.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace terrazzo {

// A handle passed down into algorithms. Cheap to copy. A default Work() is never cancelled and reports no
// progress; use it in unit tests and in programs without a graph.
class Work {
 public:
  using Report = std::function<void(double fraction, const std::string& note)>;

  Work() = default;
  // `also`: a second cancel flag, which stops only this node.
  Work(const std::atomic<bool>* cancel, const Report* report, const std::atomic<bool>* also = nullptr)
      : cancel_(cancel), also_(also), report_(report) {}

  // Throws Cancelled after the user asked to stop. Call it at least every 50 ms in your own loops.
  void check() const;
  bool cancelled() const { return set(cancel_) || set(also_); }

  // Reports the progress of this work, from 0 to 1, and a note on its state, such as "overlap 0.03".
  void progress(double fraction, const std::string& note = {}) const;
  // The same after some of all steps; `all` > 0.
  void done(double steps, double all) const { progress(steps / all); }

  // A handle for one stage of this work, whose progress maps to [from, to] of this work's progress.
  Work part(double from, double to) const;

  // The same handle without progress reports, for many short loops inside one step of an iteration.
  Work quiet() const {
    Work w = *this;
    w.report_ = nullptr;
    return w;
  }

  // Calls body(begin, end) for consecutive ranges of at most `grain` items of [0, n), on all threads of the
  // run. The ranges depend only on n and grain, not on the number of threads. Checks for cancellation before
  // every range and reports progress. Throws Cancelled, or what body throws.
  void parallel(std::size_t n, std::size_t grain,
                const std::function<void(std::size_t begin, std::size_t end)>& body) const;

  // Computes map(begin, end) → T for each range and combines the results from left to right, so the result is
  // bit-identical for any number of threads.
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
