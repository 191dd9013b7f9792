#include "nodes/load_ebsd/map_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/io/cell_rows.h"

namespace terrazzo::load_ebsd {

bool Lines::next(std::string_view& line) {
  if (at_ >= text_.size()) return false;
  before_ = at_;
  const auto end = std::min(text_.find('\n', at_), text_.size());
  line = text_.substr(at_, end - at_);
  if (line.ends_with('\r')) line.remove_suffix(1);
  at_ = end + 1, ++number_;
  return true;
}

void Lines::malformed(const std::string& what) const { malformed_row(file_, number_, what); }

void Lines::unreadable(const std::string& what, const std::string& hint) const {
  throw Error("unreadable-file", fmt::format("cannot read the EBSD map '{}': {}", file_, what), hint)
      .parameter("path");
}

void split(std::string_view line, std::vector<std::string_view>& cells, bool tabs) {
  cells.clear();
  const char* const blanks = tabs ? "\t" : " \t";
  for (std::size_t at = 0; at < line.size();) {
    const auto end = std::min(line.find_first_of(blanks, at), line.size());
    if (end > at || tabs) cells.push_back(line.substr(at, end - at));
    at = end + 1;
  }
}

std::optional<double> number_in(std::string_view cell) {
  const auto v = cell_number(cell, true);
  return v && std::isfinite(*v) ? v : std::nullopt;
}

void check_grid(const Grid& g, const Lines& lines) {
  for (const double step : {g.x_step, g.y_step})
    if (!(step > 1e-6 && step < 1e6))
      lines.unreadable(fmt::format("its steps are {} and {} µm", g.x_step, g.y_step));
  const auto most = static_cast<std::int64_t>(1) << 24;
  if (g.odd < 1 || g.rows < 1 || g.even < 0 || (g.rows > 1 && g.even < 1) || g.odd > most || g.even > most ||
      g.rows > most)
    lines.unreadable(fmt::format("its grid has {} and {} columns and {} rows", g.odd, g.even, g.rows));
  const double p = std::min(g.x_step, g.y_step);
  const double pixels = static_cast<double>(std::max(g.odd, g.even)) * g.x_step / p *
                        static_cast<double>(g.rows) * g.y_step / p;
  if (pixels > 2147483647.0)
    lines.unreadable(fmt::format("it would have {:.3g} square pixels; the limit is 2147483647", pixels));
  // Resampling a few points to very many pixels is a mistake in the file.
  if (pixels > 100 * static_cast<double>(g.count()))
    lines.unreadable(fmt::format("its steps {} and {} µm differ too much", g.x_step, g.y_step));
}

EbsdMap rasterize(const Grid& g, std::vector<MapPoint> points, std::vector<Phase> phases,
                  const Lines& lines) {
  EbsdMap out;
  out.phases = std::move(phases);
  out.pixel_size = std::min(g.x_step, g.y_step);
  const bool equal = std::abs(g.x_step - g.y_step) < 1e-4 * out.pixel_size;
  if (static_cast<std::int64_t>(points.size()) != g.count())
    lines.unreadable(fmt::format("it has {} points, but its grid has {}", points.size(), g.count()),
                     "the file may be cropped or truncated; export it again");
  if (!g.hexagonal && equal) {
    out.width = static_cast<int>(g.odd), out.height = static_cast<int>(g.rows);
    out.points = std::move(points);
    return out;
  }
  const auto across = std::min(g.odd, g.rows > 1 ? g.even : g.odd);
  const double p = out.pixel_size;
  out.width = std::max(1, static_cast<int>(std::lround(static_cast<double>(across) * g.x_step / p)));
  out.height = std::max(1, static_cast<int>(std::lround(static_cast<double>(g.rows) * g.y_step / p)));
  out.points.reserve(static_cast<std::size_t>(out.width) * out.height);
  // Points are in the middle of their cells; those of even rows of a hexagonal grid half a step further.
  for (int y = 0; y < out.height; ++y) {
    const auto row =
        std::clamp(static_cast<std::int64_t>((y + 0.5) * p / g.y_step), std::int64_t{0}, g.rows - 1);
    const std::int64_t start = row / 2 * (g.odd + g.even) + row % 2 * g.odd;
    const std::int64_t columns = row % 2 ? g.even : g.odd;
    const double shift = g.hexagonal && row % 2 ? 0.5 : 0;
    for (int x = 0; x < out.width; ++x) {
      const auto column = std::clamp(static_cast<std::int64_t>(std::floor((x + 0.5) * p / g.x_step - shift)),
                                     std::int64_t{0}, columns - 1);
      out.points.push_back(points[static_cast<std::size_t>(start + column)]);
    }
  }
  return out;
}

}  // namespace terrazzo::load_ebsd
