#include "runtime/work.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "graph/numeric_environment.h"
#include "runtime/threads/thread_marks.h"

namespace terrazzo {

void Work::check() const {
  if (cancelled()) throw Cancelled();
}

void Work::progress(double fraction, const std::string& note) const {
  if (report_ && *report_) (*report_)(from_ + (to_ - from_) * std::clamp(fraction, 0.0, 1.0), note);
}

Work Work::part(double from, double to) const {
  Work w = *this;
  w.from_ = from_ + (to_ - from_) * from;
  w.to_ = from_ + (to_ - from_) * to;
  return w;
}

void Work::parallel(std::size_t n, std::size_t grain,
                    const std::function<void(std::size_t, std::size_t)>& body) const {
  if (n == 0) return;
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t ranges = (n + grain - 1) / grain;
  std::atomic<std::size_t> finished{0};
  ThreadMark start, end;
  // A destructor, so that it also runs if a range throws.
  const struct Joined {
    ThreadMark& mark;
    ~Joined() { mark.after(); }
  } joined{end};
  const NumericEnvironment calling;
  tbb::task_group_context context;
  context.capture_fp_settings();  // also for the loops that a range starts
  start.before();
  const auto range = [&](std::size_t r) {
    start.after();
    const NumericEnvironment working;
    const struct Leaves {
      ThreadMark& mark;
      ~Leaves() { mark.before(); }
    } leaves{end};
    check();
    body(r * grain, std::min(n, (r + 1) * grain));
    const std::size_t k = finished.fetch_add(1, std::memory_order_relaxed) + 1;
    if (report_ && ranges > 1) done(k, ranges);
  };
  tbb::parallel_for(std::size_t{0}, ranges, range, context);
  // If this loop runs inside another loop in which a range failed, TBB ends this one early without an error.
  // Continuing with partial results would be wrong, so throw. The outer loop reports the failure.
  if (finished.load() != ranges) throw Cancelled();
}

}  // namespace terrazzo
