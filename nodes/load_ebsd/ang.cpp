// EDAX/TSL .ang: a header of lines that begin with #, then a line per point: the Euler angles in radians, x
// and y in µm, image quality, confidence index, phase, and more.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/reading.h"
#include "nodes/load_ebsd/map_text.h"

namespace terrazzo::load_ebsd {
namespace {

Symmetry ang_symmetry(std::string_view code, const Lines& lines) {
  using enum LaueGroup;
  static const std::map<std::string_view, Symmetry> known = {
      {"1", {Triclinic}},     {"2", {Monoclinic, 2}}, {"20", {Monoclinic, 1}},  {"21", {Monoclinic, 0}},
      {"22", {Orthorhombic}}, {"4", {TetragonalLow}}, {"42", {TetragonalHigh}}, {"3", {TrigonalLow}},
      {"32", {TrigonalHigh}}, {"6", {HexagonalLow}},  {"62", {HexagonalHigh}},  {"23", {CubicLow}},
      {"43", {CubicHigh}}};
  const auto it = known.find(code);
  if (it == known.end())
    lines.unreadable(fmt::format("the symmetry '{}' is unknown", printable(code)),
                     "use the numbers of TSL, such as 43 for m-3m and 62 for 6/mmm");
  return it->second;
}

struct Header {
  Grid grid;
  std::map<int, Phase> phases;  // by the number in the file
  bool has_grid = false;
};

void read_header_line(std::string_view line, Header& h, Phase*& phase, const Lines& lines) {
  line = trimmed_cell(line.substr(1));
  const auto end = line.find_first_of(" \t:");
  const std::string_view key = line.substr(0, end);
  std::string_view value =
      end == std::string_view::npos ? std::string_view() : trimmed_cell(line.substr(end + 1));
  if (value.starts_with(':')) value = trimmed_cell(value.substr(1));
  const auto number = [&] {
    const auto v = number_in(value);
    if (!v) lines.malformed(fmt::format("{} must be a number; it is '{}'", key, printable(value)));
    return *v;
  };
  const auto whole = [&] {
    const double v = number();
    if (v < 0 || v > 1e9 || v != std::floor(v))
      lines.malformed(fmt::format("{} must be a whole number from 0 to 1e9; it is {}", key, v));
    return static_cast<std::int64_t>(v);
  };
  if (key == "Phase") {
    const auto id = whole();
    if (h.phases.size() >= 1000) lines.malformed("there are more than 1000 phases");
    if (id > 1'000'000)
      lines.malformed(fmt::format("the number of a phase must be at most 1000000; it is {}", id));
    phase = &h.phases[static_cast<int>(id)];
  } else if (key == "MaterialName" && phase) {
    phase->name = printable(value);
  } else if (key == "Symmetry" && phase) {
    phase->symmetry = ang_symmetry(value, lines);
  } else if (key == "GRID") {
    h.has_grid = true;
    if (value != "SqrGrid" && value != "HexGrid")
      lines.malformed(fmt::format("GRID must be SqrGrid or HexGrid; it is '{}'", printable(value)));
    h.grid.hexagonal = value == "HexGrid";
  } else if (key == "XSTEP") {
    h.grid.x_step = number();
  } else if (key == "YSTEP") {
    h.grid.y_step = number();
  } else if (key == "NCOLS_ODD") {
    h.grid.odd = whole();
  } else if (key == "NCOLS_EVEN") {
    h.grid.even = whole();
  } else if (key == "NROWS") {
    h.grid.rows = whole();
  }
}

}  // namespace

EbsdMap read_ang(std::string_view text, const std::string& file) {
  Lines lines(text, file);
  Header h;
  Phase* phase = nullptr;
  std::string_view line;
  bool data = false;
  while (!data && lines.next(line)) {
    data = !trimmed_cell(line).empty() && !trimmed_cell(line).starts_with('#');
    if (!data && !trimmed_cell(line).empty()) read_header_line(trimmed_cell(line), h, phase, lines);
  }
  if (!h.has_grid || h.phases.empty())
    lines.unreadable(h.has_grid ? "its header names no phase" : "its header has no line '# GRID:'",
                     "export the map with its full header");
  check_grid(h.grid, lines);
  if (h.phases.size() > 1 && h.phases.count(0)) lines.unreadable("a phase has the number 0");
  std::vector<Phase> phases;
  std::map<int, int> position;
  for (auto& [id, p] : h.phases) position[id] = static_cast<int>(phases.size()), phases.push_back(p);
  if (phases.size() == 1) position[0] = 0;  // maps of one phase number it 0 or 1

  std::vector<MapPoint> points;
  std::vector<std::string_view> cells;
  if (!data) lines.unreadable("it has no points");
  lines.back();
  while (lines.next(line)) {
    if (trimmed_cell(line).empty()) continue;
    split(line, cells);
    if (cells.size() < 8) lines.malformed(fmt::format("{} numbers; at least 8 are expected", cells.size()));
    double v[8];
    for (std::size_t i = 0; i < 8; ++i) {
      const auto n = number_in(cells[i]);
      if (!n) lines.malformed(fmt::format("'{}' is not a number", printable(cells[i])));
      v[i] = *n;
    }
    for (int i = 0; i < 3; ++i)
      if (std::abs(v[i]) > 13)  // 4π marks points that were not indexed
        lines.malformed(fmt::format("the Euler angle {} must be in radians, from -13 to 13", v[i]));
    MapPoint p;
    p.quality = static_cast<float>(v[5]), p.confidence = static_cast<float>(v[6]);
    const bool indexed = v[6] > -1 && v[0] < 12.5;
    const auto known = v[7] == std::floor(v[7]) && std::abs(v[7]) < 1e6
                           ? position.find(static_cast<int>(v[7]))
                           : position.end();
    if (known == position.end() && v[7] != 0 && v[7] != -1)
      lines.malformed(fmt::format("the point is of phase {}, which the header does not name", v[7]));
    if (indexed && known != position.end()) {
      p.phase = known->second;
      p.orientation = from_bunge(v[0], v[1], v[2]);
    }
    points.push_back(p);
    if (static_cast<std::int64_t>(points.size()) > h.grid.count())
      lines.malformed(fmt::format("more points than the {} of the grid", h.grid.count()));
  }
  return rasterize(h.grid, std::move(points), std::move(phases), lines);
}

}  // namespace terrazzo::load_ebsd
