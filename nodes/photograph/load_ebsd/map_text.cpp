#include "nodes/photograph/load_ebsd/map_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/reading.h"
#include "nodes/common/io/text_input.h"

namespace terrazzo::load_ebsd {

bool Lines::next(std::string_view& line) {
  before_ = at_;
  if (!next_line(text_, at_, line)) return false;
  ++number_;
  return true;
}

void Lines::malformed(const std::string& what) const { malformed_row(file_, number_, what); }

void Lines::contradiction(int line, const std::string& what) const {
  throw Error("malformed-row", fmt::format("{}:{}: {}", file_, line, what),
              "export the map again, or correct its header")
      .parameter("path");
}

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

double last_digit(std::string_view number) {
  int exponent = 0;
  const auto e = number.find_first_of("eE");
  if (e != std::string_view::npos) {
    const std::string_view digits =
        number.substr(e + 1 < number.size() && number[e + 1] == '+' ? e + 2 : e + 1);
    std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
  }
  const std::string_view mantissa = number.substr(0, e);
  const auto point = mantissa.find_first_of(".,");
  if (point != std::string_view::npos) exponent -= static_cast<int>(mantissa.size() - point) - 1;
  return std::pow(10.0, std::clamp(exponent, -300, 300));
}

void PointList::add(const MapPoint& point, std::string_view x_cell, std::string_view y_cell, double unit,
                    const Lines& lines) {
  const auto coordinate = [&](std::string_view cell, std::vector<double>& values, double& digit) {
    const auto v = number_in(cell);
    if (!v) lines.malformed(fmt::format("'{}' is not a number", printable(cell)));
    if (std::abs(*v) > 1e9) lines.malformed(fmt::format("the coordinate {} is above 1e9", *v));
    values.push_back(*v * unit);
    digit = std::min(digit, last_digit(cell) * unit);
  };
  coordinate(x_cell, x, x_digit);
  coordinate(y_cell, y, y_digit);
  points.push_back(point);
  line.push_back(lines.number());
}

PointList read_points(
    Lines& lines, const std::function<void(const std::vector<std::string_view>& cells, PointList&)>& add) {
  PointList points;
  std::string_view line;
  std::vector<std::string_view> cells;
  while (lines.next(line)) {
    split(line, cells);
    if (!cells.empty()) add(cells, points);
  }
  if (points.points.empty()) lines.unreadable("it has no points", "export the map again, with its points");
  return points;
}

}  // namespace terrazzo::load_ebsd
