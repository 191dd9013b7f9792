// One axis of a figure: its range, its ticks and their labels.
#pragma once

#include <string>
#include <vector>

namespace terrazzo {

struct PlotAxis {
  double lo = 0, hi = 1;  // in data units; both positive if log
  bool log = false;
  std::vector<double> ticks;  // with labels
  std::vector<double> minor;  // without labels
  std::vector<std::string> words;

  double place(double v) const;  // 0 at lo, 1 at hi; may be outside that range
};

// Makes an axis around the finite (if log, positive) `values`, with about `count` ticks at most at 1, 2 or 5
// × 10^k. `with_zero`: the range includes zero. `tight`: the range ends at the values, not at ticks.
PlotAxis make_axis(const std::vector<double>& values, bool log, bool with_zero, bool tight, int count);

// With as many digits as needed to distinguish neighbors `step` apart: "0.05", "12000", "1.5e-7".
std::string tick_word(double v, double step);

}  // namespace terrazzo
