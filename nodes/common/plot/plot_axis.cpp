#include "nodes/common/plot/plot_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"

namespace terrazzo {

double PlotAxis::place(double v) const {
  if (log) return v > 0 ? std::log(v / lo) / std::log(hi / lo) : -1e9;
  return (v - lo) / (hi - lo);
}

std::string tick_word(double v, double step) {
  const double size = std::max(std::abs(v), std::abs(step));
  if (std::abs(v) < 1e-9 * std::abs(step)) return "0";
  if (size >= 1e6 || std::abs(step) < 1e-4) {
    const int power = round_down(std::log10(std::abs(v)) + 1e-9);
    const double lead = v / std::pow(10, power);
    const int digits = std::clamp(power - round_down(std::log10(std::abs(step)) + 1e-9), 0, 6);
    return fmt::format("{:.{}f}e{}", lead, digits, power);
  }
  const int digits = std::clamp(-round_down(std::log10(std::abs(step)) + 1e-9), 0, 5);
  return fmt::format("{:.{}f}", v, digits);
}

namespace {

double nice_step(double span, int count) {
  const double raw = span / std::max(1, count), power = std::pow(10, std::floor(std::log10(raw)));
  const double lead = raw / power;
  return power * (lead <= 1.0001 ? 1 : lead <= 2.0001 ? 2 : lead <= 5.0001 ? 5 : 10);
}

void log_ticks(PlotAxis& axis, int count) {
  const int first = round_down(std::log10(axis.lo) + 1e-9);
  const int last = round_up(std::log10(axis.hi) - 1e-9);
  const int every = std::max(1, (last - first + count - 1) / std::max(1, count));
  const bool few = last - first <= 2;  // then 2 and 5 are labeled too
  const double slack = 1e-9;
  for (int k = first; k <= last; ++k)
    for (int m = 1; m < 10; ++m) {
      const double v = m * std::pow(10, k);
      if (v < axis.lo * (1 - slack) || v > axis.hi * (1 + slack)) continue;
      if ((m == 1 && (k - first) % every == 0) || (few && (m == 2 || m == 5))) {
        axis.ticks.push_back(v);
        axis.words.push_back(k >= -3 && k <= 4 ? fmt::format("{:g}", v) : fmt::format("{}e{}", m, k));
      } else {
        axis.minor.push_back(v);
      }
    }
}

}  // namespace

PlotAxis make_axis(const std::vector<double>& values, bool log, bool with_zero, bool tight, int count) {
  PlotAxis axis;
  axis.log = log;
  double lo = INFINITY, hi = -INFINITY;
  for (double v : values)
    if (std::isfinite(v) && (!log || v > 0)) {
      lo = std::min(lo, v);
      hi = std::max(hi, v);
    }
  if (lo > hi) {
    lo = log ? 0.1 : 0;
    hi = 1;
  }
  if (log) {
    if (!(hi > lo * 1.0001)) {
      lo /= 2;
      hi *= 2;
    }
    axis.lo = lo;
    axis.hi = hi;
    if (!tight) {  // extend to the next 1, 2 or 5
      auto step = [](double v, bool up) {
        const double power = std::pow(10, std::floor(std::log10(v))), lead = v / power;
        if (up) return power * (lead <= 1.0001 ? 1 : lead <= 2.0001 ? 2 : lead <= 5.0001 ? 5 : 10);
        return power * (lead >= 5 ? 5 : lead >= 2 ? 2 : 1);
      };
      axis.lo = step(lo, false);
      axis.hi = step(hi, true);
    }
    log_ticks(axis, count);
    return axis;
  }
  // Include zero if it is near; if it is far away, the differences matter more.
  if (with_zero || (!tight && lo > 0 && lo < 0.4 * hi)) {
    lo = std::min(lo, 0.0);
    hi = std::max(hi, 0.0);
  }
  if (!(hi - lo > 1e-12 * std::max(std::abs(hi), std::abs(lo)))) {
    const double room = hi == 0 ? 1 : 0.5 * std::abs(hi);
    if (with_zero && hi >= 0) {
      lo = 0;
      hi = hi == 0 ? 1 : hi;
    } else {
      lo -= room;
      hi += room;
    }
  }
  const double step = nice_step(hi - lo, count);
  axis.lo = tight ? lo : std::floor(lo / step + 1e-9) * step;
  axis.hi = tight ? hi : std::ceil(hi / step - 1e-9) * step;
  for (double k = std::ceil(axis.lo / step - 1e-9); k <= std::floor(axis.hi / step + 1e-9); ++k) {
    axis.ticks.push_back(k * step);
    axis.words.push_back(tick_word(k * step, step));
  }
  return axis;
}

}  // namespace terrazzo
