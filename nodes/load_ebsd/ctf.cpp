// Oxford/HKL .ctf (Channel Text File): lines of a name and a value, the phases, the names of the columns,
// then a line per point with Euler angles in degrees.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>

#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/reading.h"
#include "nodes/load_ebsd/map_text.h"

namespace terrazzo::load_ebsd {
namespace {

// "3.66;3.66;3.66 TAB 90;90;90 TAB Iron fcc TAB 11 TAB 225": edges, angles, name, Laue group, space group.
Phase read_phase(std::string_view line, const Lines& lines) {
  std::vector<std::string_view> cells;
  split(line, cells, true);
  if (cells.size() < 4)
    lines.malformed(
        "a phase needs edges, angles, a name and the number of its Laue group, separated by tabs");
  const auto group = number_in(trimmed_cell(cells[3]));
  if (!group || *group < 1 || *group > 11 || *group != std::floor(*group))
    lines.malformed(
        fmt::format("the Laue group must be a whole number from 1 to 11; it is '{}'", printable(cells[3])));
  return {printable(trimmed_cell(cells[2])), {static_cast<LaueGroup>(static_cast<int>(*group) - 1)}};
}

}  // namespace

EbsdMap read_ctf(std::string_view text, const std::string& file) {
  Lines lines(text, file);
  std::string_view line;
  if (!lines.next(line) || !trimmed_cell(line).starts_with("Channel Text File"))
    lines.unreadable("it does not begin with 'Channel Text File'");
  Grid grid;
  std::vector<Phase> phases;
  std::vector<std::string_view> cells;
  std::map<std::string_view, std::size_t> columns;
  while (columns.empty() && lines.next(line)) {
    split(line, cells);
    if (cells.empty()) continue;
    const std::string_view key = cells[0];
    const auto number = [&] {
      const auto v = cells.size() > 1 ? number_in(cells[1]) : std::nullopt;
      if (!v) lines.malformed(fmt::format("{} is not a number", key));
      return *v;
    };
    const auto whole = [&] {
      const double v = number();
      if (v < 0 || v > 1e9 || v != std::floor(v))
        lines.malformed(fmt::format("{} must be a whole number from 0 to 1e9; it is {}", key, v));
      return static_cast<std::int64_t>(v);
    };
    if (key == "JobMode" && cells.size() > 1 && cells[1] != "Grid") {
      lines.unreadable(fmt::format("its JobMode is '{}'", printable(cells[1])), "only maps (Grid) are read");
    } else if (key == "XCells") {
      grid.odd = grid.even = whole();
    } else if (key == "YCells") {
      grid.rows = whole();
    } else if (key == "XStep") {
      grid.x_step = number();
    } else if (key == "YStep") {
      grid.y_step = number();
    } else if (key == "Phases") {
      const auto count = whole();
      if (count < 1 || count > 1000)
        lines.malformed(fmt::format("Phases must be from 1 to 1000; it is {}", count));
      for (std::int64_t k = 0; k < count; ++k) {
        if (!lines.next(line)) lines.unreadable("it ends within its phases");
        phases.push_back(read_phase(line, lines));
      }
    } else if (key == "Phase") {
      for (std::size_t i = 0; i < cells.size(); ++i) columns[cells[i]] = i;
    }
  }
  for (const char* name : {"Phase", "Euler1", "Euler2", "Euler3"})
    if (!columns.count(name)) lines.unreadable(fmt::format("it has no column {}", name));
  if (phases.empty()) lines.unreadable("its header names no phase");
  check_grid(grid, lines);
  const auto optional = [&](const char* name) {
    const auto it = columns.find(name);
    return it == columns.end() ? std::string_view::npos : it->second;
  };
  const std::size_t at[] = {columns["Phase"],  columns["Euler1"], columns["Euler2"],
                            columns["Euler3"], optional("BC"),    optional("MAD")};
  std::vector<MapPoint> points;
  while (lines.next(line)) {
    split(line, cells);
    if (cells.empty()) continue;
    double v[6] = {};
    for (std::size_t i = 0; i < 6; ++i) {
      if (at[i] == std::string_view::npos) continue;
      if (at[i] >= cells.size())
        lines.malformed(fmt::format("{} numbers; {} are expected", cells.size(), columns.size()));
      const auto n = number_in(cells[at[i]]);
      if (!n) lines.malformed(fmt::format("'{}' is not a number", printable(cells[at[i]])));
      v[i] = *n;
    }
    if (v[0] < 0 || v[0] > static_cast<double>(phases.size()) || v[0] != std::floor(v[0]))
      lines.malformed(fmt::format("the point is of phase {}, but there are {} phases", v[0], phases.size()));
    for (int i = 1; i <= 3; ++i)
      if (std::abs(v[i]) > 720)
        lines.malformed(fmt::format("the Euler angle {} must be in degrees, from -720 to 720", v[i]));
    MapPoint p;
    p.phase = static_cast<int>(v[0]) - 1;
    constexpr double degree = std::numbers::pi / 180;
    if (p.phase >= 0) p.orientation = from_bunge(v[1] * degree, v[2] * degree, v[3] * degree);
    p.quality = static_cast<float>(v[4]), p.deviation = static_cast<float>(v[5]);
    points.push_back(p);
    if (static_cast<std::int64_t>(points.size()) > grid.count())
      lines.malformed(fmt::format("more points than the {} of the grid", grid.count()));
  }
  return rasterize(grid, std::move(points), std::move(phases), lines);
}

}  // namespace terrazzo::load_ebsd
