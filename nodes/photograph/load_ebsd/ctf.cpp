// Oxford/HKL .ctf (Channel Text File): lines of a name and a value, the phases, the names of the columns,
// then a line per point with Euler angles in degrees.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/reading.h"
#include "nodes/photograph/load_ebsd/grid.h"

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

struct Header {
  GridHeader grid;
  std::vector<Phase> phases;
  std::map<std::string, std::size_t, std::less<>> columns;
};

void read_phases(double count, Header& h, Lines& lines) {
  if (count < 1 || count > 1000)
    lines.malformed(fmt::format("Phases must be from 1 to 1000; it is {}", count));
  std::string_view line;
  for (int k = 0; k < static_cast<int>(count); ++k) {
    if (!lines.next(line)) lines.unreadable("it ends within its phases");
    h.phases.push_back(read_phase(line, lines));
  }
}

// One line above the points.
void read_header_line(const std::vector<std::string_view>& cells, Header& h, Lines& lines) {
  const std::string_view key = cells[0];
  const auto number = [&] {
    const auto v = cells.size() > 1 ? number_in(cells[1]) : std::nullopt;
    if (!v) lines.malformed(fmt::format("{} is not a number", key));
    return HeaderNumber{*v, last_digit(cells[1])};
  };
  const auto whole = [&] {
    const double v = number().value;
    if (v < 0 || v > 1e9 || v != std::floor(v))
      lines.malformed(fmt::format("{} must be a whole number from 0 to 1e9; it is {}", key, v));
    return static_cast<std::int64_t>(v);
  };
  if (key == "JobMode" && cells.size() > 1 && cells[1] != "Grid") {
    lines.unreadable(fmt::format("its JobMode is '{}'", printable(cells[1])), "only maps (Grid) are read");
  } else if (key == "XCells") {
    h.grid.odd = h.grid.even = whole();
  } else if (key == "YCells") {
    h.grid.rows = whole();
  } else if (key == "XStep") {
    h.grid.x_step = number();
  } else if (key == "YStep") {
    h.grid.y_step = number();
  } else if (key == "Phases") {
    read_phases(number().value, h, lines);
  } else if (key == "Phase") {
    for (std::size_t i = 0; i < cells.size(); ++i) h.columns.emplace(cells[i], i);
  }
}

Header read_header(Lines& lines) {
  std::string_view line;
  if (!lines.next(line) || !trimmed_cell(line).starts_with("Channel Text File"))
    lines.unreadable("it does not begin with 'Channel Text File'");
  Header h;
  h.grid.x_step_name = "XStep";
  h.grid.y_step_name = "YStep";
  h.grid.columns_name = "XCells";
  h.grid.rows_name = "YCells";
  std::vector<std::string_view> cells;
  while (h.columns.empty() && lines.next(line)) {
    split(line, cells);
    if (!cells.empty()) read_header_line(cells, h, lines);
  }
  for (const char* name : {"Phase", "X", "Y", "Euler1", "Euler2", "Euler3"})
    if (!h.columns.count(name)) lines.unreadable(fmt::format("it has no column {}", name));
  if (h.phases.empty()) lines.unreadable("its header names no phase");
  return h;
}

MapPoint read_point(const double (&v)[6], std::size_t phases, const Lines& lines) {
  if (v[0] < 0 || v[0] > static_cast<double>(phases) || v[0] != std::floor(v[0]))
    lines.malformed(fmt::format("the point is of phase {}, but there are {} phases", v[0], phases));
  for (int i = 1; i <= 3; ++i)
    if (std::abs(v[i]) > 720)
      lines.malformed(fmt::format("the Euler angle {} must be in degrees, from -720 to 720", v[i]));
  MapPoint p;
  p.phase = static_cast<int>(v[0]) - 1;
  constexpr double kDegree = std::numbers::pi / 180;
  if (p.phase >= 0) p.orientation = from_bunge(v[1] * kDegree, v[2] * kDegree, v[3] * kDegree);
  p.quality = static_cast<float>(v[4]);
  p.deviation = static_cast<float>(v[5]);
  return p;
}

}  // namespace

EbsdMap read_ctf(std::string_view text, const std::string& file, std::uint64_t memory) {
  Lines lines(text, file);
  Header h = read_header(lines);
  const auto optional = [&](const char* name) {
    const auto it = h.columns.find(name);
    return it == h.columns.end() ? std::string_view::npos : it->second;
  };
  const std::size_t at[] = {h.columns["Phase"],  h.columns["Euler1"], h.columns["Euler2"],
                            h.columns["Euler3"], optional("BC"),      optional("MAD")};
  const std::size_t x = h.columns["X"], y = h.columns["Y"];
  const PointList points = read_points(lines, [&](const std::vector<std::string_view>& cells, PointList& to) {
    if (cells[0] == "Channel") lines.malformed("a second header; a file may have one map");
    double v[6] = {};
    for (std::size_t i = 0; i < 6; ++i) {
      if (at[i] == std::string_view::npos) continue;
      if (std::max({at[i], x, y}) >= cells.size())
        lines.malformed(fmt::format("{} numbers; {} are expected", cells.size(), h.columns.size()));
      const auto n = number_in(cells[at[i]]);
      if (!n) lines.malformed(fmt::format("'{}' is not a number", printable(cells[at[i]])));
      v[i] = *n;
    }
    to.add(read_point(v, h.phases.size(), lines), cells[x], cells[y], 1, lines);
  });
  const Grid grid = find_grid(points, h.grid, memory, lines);
  return rasterize(grid, points, std::move(h.phases), memory, lines);
}

}  // namespace terrazzo::load_ebsd
