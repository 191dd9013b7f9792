// One axis of a figure: its range, its ticks, their words.
#pragma once

#include <string>
#include <vector>

namespace terrazzo {

struct PlotAxis {
  double lo = 0, hi = 1;  // of the data space; both positive where log
  bool log = false;
  std::vector<double> ticks;  // with a word each
  std::vector<double> minor;  // without
  std::vector<std::string> words;

  double place(double v) const;  // 0 at lo, 1 at hi; may lie outside
};

// Around `values` (those that are finite, and positive where log), at most about `count` ticks at 1, 2 or 5 ×
// 10^k. `with_zero`: the range starts at zero (or ends there). `tight`: the range is that of the values, not
// of the ticks.
PlotAxis make_axis(const std::vector<double>& values, bool log, bool with_zero, bool tight, int count);

// In as many digits as tell neighbours `step` apart: "0.05", "12000", "1.5e-7".
std::string tick_word(double v, double step);

}  // namespace terrazzo
