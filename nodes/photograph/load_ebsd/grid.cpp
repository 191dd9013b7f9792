#include "nodes/photograph/load_ebsd/grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "nodes/photograph/load_ebsd/axis.h"
#include "runtime/memory.h"

namespace terrazzo::load_ebsd {
namespace {

constexpr std::int64_t kMostPlaces = 2147483647;
// A grid with fewer points than this share of its places is a mistake in the file.
constexpr std::int64_t kMostPlacesPerPoint = 100;

void check_header(const GridHeader& h, const Lines& lines) {
  for (const auto& step : {h.x_step, h.y_step})
    if (step && !(std::abs(step->value) > 1e-6 && std::abs(step->value) < 1e6))
      lines.unreadable(fmt::format("its steps are {} and {} µm", h.x_step ? h.x_step->value : 0,
                                   h.y_step ? h.y_step->value : 0));
  if (h.odd.value_or(1) < 1 || h.rows.value_or(1) < 1 || (h.rows.value_or(2) > 1 && h.even.value_or(1) < 1))
    lines.unreadable(fmt::format("its grid has {} and {} columns and {} rows", h.odd.value_or(0),
                                 h.even.value_or(0), h.rows.value_or(0)));
}

// The first point in a row that is an odd number of rows away from that of the first point.
std::size_t first_of_other_rows(const Axis& y) {
  for (std::size_t i = 1; i < y.at.size(); ++i)
    if ((y.at[i] - y.at[0]) % 2 != 0) return i;
  return 0;
}

// Whether only every second place of the axes' steps has points, as on a chessboard.
bool is_staggered(const Axis& x, const Axis& y) {
  if (x.count < 2 || y.count < 2) return false;
  const int first = (x.at[0] + y.at[0]) % 2;
  for (std::size_t i = 0; i < x.at.size(); ++i)
    if ((x.at[i] + y.at[i]) % 2 != first) return false;
  return true;
}

// Of an axis with points at half of the header's steps, though rows are not shifted.
[[noreturn]] void not_at_half_steps(const Axis& axis, const AxisCoordinates& c, const Lines& lines) {
  std::size_t i = 0;
  while (i + 1 < axis.at.size() && (axis.at[i] - axis.at[0]) % 2 == 0) ++i;
  lines.contradiction(c.line[i], fmt::format("{} is {:.7g} µm, half a step of {} µm ({}) from the others",
                                             c.name, c.values[i], c.header_step->value, c.header_name));
}

void check_kind(const GridHeader& h, const Axis& x, const Axis& y, bool staggered, const PointList& p,
                const Lines& lines) {
  if (!h.hexagonal || x.count < 2 || y.count < 2) return;
  if (*h.hexagonal && staggered && h.x_step && !x.half && !y.half)
    lines.contradiction(p.line[0],
                        fmt::format("the points of a row are {:.5g} µm apart in the map, but {} is {} µm",
                                    2 * x.step, h.x_step_name, h.x_step->value));
  if (*h.hexagonal == staggered) return;
  const std::size_t i = first_of_other_rows(y);
  lines.contradiction(
      p.line[i],
      staggered
          ? fmt::format("x is {:.7g} µm, half a step from the points of the rows beside it, but GRID is "
                        "SqrGrid",
                        p.x[i])
          : fmt::format("x is {:.7g} µm, not half a step from the points of the rows beside it, but GRID is "
                        "HexGrid",
                        p.x[i]));
}

// Throws if the header's counts are not those of the coordinates.
void check_counts(const GridHeader& h, const Grid& g, const Axis& x, const Axis& y, const PointList& p,
                  const Lines& lines) {
  const auto even = h.rows.value_or(g.rows) > 1 ? h.even : h.odd;
  const bool rows_agree = h.rows.value_or(g.rows) == g.rows;
  bool columns_agree = true;
  if (h.odd && !g.staggered) {
    columns_agree = *h.odd == g.columns[0] && even.value_or(*h.odd) == g.columns[0];
  } else if (h.odd) {
    const std::int64_t a = *h.odd, b = even.value_or(a), n0 = g.columns[0], n1 = g.columns[1];
    // Formats without hexagonal grids (.ctf) have one number for both kinds of rows.
    columns_agree =
        (a == n0 && b == n1) || (a == n1 && b == n0) || (a == b && (a == n0 || a == n1 || a == n0 + n1));
  }
  if (rows_agree && columns_agree) return;
  // A point beyond what the header says contradicts it; points that are missing do not show where.
  const std::int64_t most = h.odd && !g.staggered ? *h.odd : x.count;
  for (std::size_t i = 0; i < p.line.size(); ++i) {
    if (x.at[i] >= most)
      lines.contradiction(p.line[i], fmt::format("x is {:.7g} µm: column {} of {} ({})", p.x[i], x.at[i] + 1,
                                                 most, h.columns_name));
    if (h.rows && y.at[i] >= *h.rows)
      lines.contradiction(p.line[i], fmt::format("y is {:.7g} µm: row {} of {} ({})", p.y[i], y.at[i] + 1,
                                                 *h.rows, h.rows_name));
  }
  const std::string columns =
      g.staggered ? fmt::format("{} and {}", g.columns[0], g.columns[1]) : fmt::format("{}", g.columns[0]);
  const std::string said = h.odd == even ? fmt::format("{}", h.odd.value_or(0))
                                         : fmt::format("{} and {}", h.odd.value_or(0), even.value_or(0));
  lines.unreadable(
      fmt::format("its coordinates have {} columns and {} rows, but its header has {} ({}) and {} ({})",
                  columns, g.rows, said, h.columns_name, h.rows.value_or(0), h.rows_name),
      "the file may be cropped or truncated; export it again, or correct its header");
}

// Puts every point in its place.
void place_points(Grid& g, const Axis& x, const Axis& y, const PointList& p, std::uint64_t memory,
                  const Lines& lines) {
  g.width = std::max(g.columns[0], g.columns[1]);
  const auto places = static_cast<double>(g.width) * g.rows;
  if (places > kMostPlaces || places > static_cast<double>(kMostPlacesPerPoint) * p.points.size())
    lines.unreadable(fmt::format("its {} points are too few for their grid of {} columns and {} rows",
                                 p.points.size(), g.width, g.rows));
  require_memory(places * sizeof(std::int32_t), memory, "the grid of the map");
  g.points.assign(g.width * g.rows, -1);
  for (std::size_t i = 0; i < p.points.size(); ++i) {
    const std::int64_t row = y.at[i], column = g.staggered ? x.at[i] / 2 : x.at[i];
    auto& place = g.points[row * g.width + column];
    if (place >= 0)
      lines.contradiction(p.line[i],
                          fmt::format("a second point at x {:.7g} and y {:.7g} µm; the first is in line {}",
                                      p.x[i], p.y[i], p.line[place]));
    place = i;
  }
  std::int64_t all = 0;
  for (std::int64_t row = 0; row < g.rows; ++row) all += g.columns[g.shift(row)];
  g.missing = all - static_cast<std::int64_t>(p.points.size());
}

// As if the map were turned over its diagonal.
void transpose(GridHeader& h, Axis& x, Axis& y) {
  std::swap(x, y);
  std::swap(h.x_step, h.y_step);
  std::swap(h.x_step_name, h.y_step_name);
  std::swap(h.columns_name, h.rows_name);
  std::swap(h.odd, h.rows);
  h.even = h.odd;
}

}  // namespace

Grid find_grid(const PointList& p, const GridHeader& header, std::uint64_t memory, const Lines& lines) {
  GridHeader h = header;
  check_header(h, lines);
  const AxisCoordinates xs{"x", p.x, p.x_digit, h.x_step, h.x_step_name, p.line};
  const AxisCoordinates ys{"y", p.y, p.y_digit, h.y_step, h.y_step_name, p.line};
  Axis x = find_axis(xs, lines), y = find_axis(ys, lines);
  Grid g;
  g.staggered = is_staggered(x, y) && !(x.half && y.half);
  check_kind(h, x, y, g.staggered, p, lines);
  if (!g.staggered && x.half) not_at_half_steps(x, xs, lines);
  if (!g.staggered && y.half) not_at_half_steps(y, ys, lines);
  // The steps along a row of a hexagonal grid are wider than those between rows, but have a point at every
  // second place only.
  g.transposed = g.staggered && (y.half || (!x.half && y.step < x.step));
  if (g.transposed) transpose(h, x, y);
  if (x.step == 0) x.step = y.step;
  if (y.step == 0) y.step = x.step;
  if (x.step == 0) lines.unreadable("its header has no steps, and all of its points have one place");
  g.rows = y.count;
  g.x_step = g.staggered ? 2 * x.step : x.step;
  g.y_step = y.step;
  if (g.staggered) {
    g.first_shift = (x.at[0] + y.at[0]) % 2;
    for (const std::int32_t at : x.at) {
      std::int64_t& columns = g.columns[at % 2];
      columns = std::max<std::int64_t>(columns, at / 2 + 1);
    }
  } else {
    g.columns[0] = x.count;
  }
  if (g.transposed) {
    PointList turned;  // only what messages need
    turned.x = p.y;
    turned.y = p.x;
    turned.line = p.line;
    check_counts(h, g, x, y, turned, lines);
  } else {
    check_counts(h, g, x, y, p, lines);
  }
  place_points(g, x, y, p, memory, lines);
  return g;
}

}  // namespace terrazzo::load_ebsd
