#include "nodes/photograph/load_ebsd/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace terrazzo::load_ebsd {
namespace {

// Largest deviation of a coordinate from its place on the grid, in steps, besides rounding. Coordinates of
// one column may differ by as much.
constexpr double kJitter = 0.05;

// How far the header's step may be from that of the coordinates: its last digit may be rounded, but a step is
// not given to one digit only.
double rounding_of(const HeaderNumber& step) {
  const double size = std::abs(step.value);
  return std::min(step.digit / 2, 0.05 * size) + 1e-4 * size;
}

// The first line whose coordinate does not continue the one before in steps of the header, or at least the
// first that has another coordinate.
[[noreturn]] void contradict(const AxisCoordinates& c, double gap, const Lines& lines) {
  const double step = std::abs(c.header_step->value), same = kJitter * std::min(step, gap);
  std::size_t first = 0;
  for (std::size_t i = 1; i < c.values.size(); ++i) {
    const double change = std::abs(c.values[i] - c.values[i - 1]);
    if (change <= same) continue;
    if (first == 0) first = i;
    const double steps = std::max(1.0, std::round(change / step));
    if (std::abs(change - steps * step) <= c.digit + steps * rounding_of(*c.header_step)) continue;
    first = i;
    break;
  }
  lines.contradiction(
      c.line[first],
      fmt::format("{} goes from {:.7g} to {:.7g} µm, and advances by {:.4g} µm in the map, but {} is "
                  "{} µm",
                  c.name, c.values[first == 0 ? 0 : first - 1], c.values[first], gap, c.header_name,
                  c.header_step->value));
}

// A negative step in the header says that coordinates descend.
void check_direction(const AxisCoordinates& c, const Lines& lines) {
  if (!c.header_step || c.header_step->value > 0) return;
  for (std::size_t i = 1; i < c.values.size(); ++i)
    if (const double change = c.values[i] - c.values[i - 1]; change != 0) {
      if (change > 0)
        lines.contradiction(c.line[i],
                            fmt::format("{} rises from {:.7g} to {:.7g} µm, but {} is {} µm", c.name,
                                        c.values[i - 1], c.values[i], c.header_name, c.header_step->value));
      return;
    }
}

// The different coordinates in ascending order. Those that differ by less than `same` are one, their mean.
std::vector<double> distinct(std::vector<double> values, double same) {
  std::sort(values.begin(), values.end());
  std::vector<double> out;
  for (std::size_t from = 0, i = 1; i <= values.size(); ++i) {
    if (i < values.size() && values[i] - values[from] <= same) continue;
    out.push_back((values[from] + values[i - 1]) / 2);
    from = i;
  }
  return out;
}

double smallest_gap(const std::vector<double>& places) {
  double gap = places[1] - places[0];
  for (std::size_t i = 2; i < places.size(); ++i) gap = std::min(gap, places[i] - places[i - 1]);
  return gap;
}

// The step that explains all gaps as multiples of about `base`: the gaps of one step tell it well enough to
// count the steps in wider ones. 0 if no gap is one step wide.
double refined_step(const std::vector<double>& places, double base) {
  double sum = 0, single = 0;
  for (std::size_t i = 1; i < places.size(); ++i)
    if (const double gap = places[i] - places[i - 1]; std::round(gap / base) == 1) {
      sum += gap;
      ++single;
    }
  if (single == 0) return 0;
  const double step = sum / single;
  double steps = 0;
  for (std::size_t i = 1; i < places.size(); ++i) steps += std::round((places[i] - places[i - 1]) / step);
  return (places.back() - places.front()) / steps;
}

// The step of the header or half of it, whichever the smallest gap is.
double base_step(const AxisCoordinates& c, double smallest_gap, bool& half, const Lines& lines) {
  half = false;
  if (!c.header_step) return smallest_gap;
  const double step = std::abs(c.header_step->value), rounding = rounding_of(*c.header_step) + c.digit;
  const double jitter = kJitter * step;
  if (std::abs(smallest_gap - step) <= rounding + jitter) return step;
  if (std::abs(smallest_gap - step / 2) > rounding + jitter / 2) contradict(c, smallest_gap, lines);
  half = true;
  return step / 2;
}

}  // namespace

Axis find_axis(const AxisCoordinates& c, const Lines& lines) {
  check_direction(c, lines);
  Axis out;
  double largest = 0;
  for (const double v : c.values) largest = std::max(largest, std::abs(v));
  const double step = c.header_step ? std::abs(c.header_step->value) : 0;
  const std::vector<double> places = distinct(c.values, std::max(kJitter * step, 1e-9 * largest));
  out.origin = places.front();
  out.step = step;
  out.at.assign(c.values.size(), 0);
  if (places.size() == 1) {
    // Coordinates that differ by much less than the header's step are in another unit.
    const auto [least, most] = std::minmax_element(c.values.begin(), c.values.end());
    if (c.header_step && *most - *least > 2 * c.digit)
      contradict(c, smallest_gap(distinct(c.values, 1e-9 * largest)), lines);
    return out;
  }
  const double gap = smallest_gap(places);
  const double base = base_step(c, gap, out.half, lines);
  out.step = refined_step(places, base);
  if (out.step == 0) contradict(c, gap, lines);
  const double steps = std::round((places.back() - places.front()) / out.step);
  if (c.header_step) {
    const double allowed = (c.digit + kJitter * base) / steps + rounding_of(*c.header_step);
    if (std::abs(out.step - base) > allowed) contradict(c, out.half ? 2 * out.step : out.step, lines);
    // The header's number has more digits than the coordinates tell, unless it does not reach the last one.
    if (std::abs(out.step - base) * steps <= c.digit + kJitter * base) out.step = base;
  }
  if (steps >= 1 << 24)
    lines.unreadable(
        fmt::format("its {} coordinates span {:.3g} steps of {:.3g} µm", c.name, steps, out.step));
  out.count = static_cast<std::int64_t>(steps) + 1;
  const double tolerance = std::min(c.digit + 2 * kJitter * out.step, 0.4 * out.step);
  for (std::size_t i = 0; i < c.values.size(); ++i) {
    const double at = (c.values[i] - out.origin) / out.step, place = std::round(at);
    if (std::abs(at - place) * out.step > tolerance)
      lines.contradiction(
          c.line[i],
          fmt::format("{} is {:.7g} µm, which is not on a grid from {:.7g} µm in steps of {:.5g} µm", c.name,
                      c.values[i], out.origin, out.step));
    out.at[i] = static_cast<std::int32_t>(std::clamp(place, 0.0, steps));
  }
  return out;
}

}  // namespace terrazzo::load_ebsd
