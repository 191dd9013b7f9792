// What the readers of both formats share: lines, numbers and rows of points.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nodes/load_ebsd/ebsd_map.h"

namespace terrazzo::load_ebsd {

// The lines of a text, numbered from 1, without their ends.
class Lines {
 public:
  Lines(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}
  bool next(std::string_view& line);
  void back() { at_ = before_, --number_; }  // to read the last line again
  // Throws Error "malformed-row" with file and line, or "unreadable-file".
  [[noreturn]] void malformed(const std::string& what) const;
  [[noreturn]] void unreadable(const std::string& what, const std::string& hint = {}) const;

 private:
  std::string_view text_;
  std::string file_;
  std::size_t at_ = 0, before_ = 0;
  int number_ = 0;
};

// Cells separated by blanks, or by tabs alone.
void split(std::string_view line, std::vector<std::string_view>& cells, bool tabs = false);
// A finite number; a comma is read as a decimal point.
std::optional<double> number_in(std::string_view);

// A grid of rows of points, as the file has them. Odd rows (the 1st, 3rd …) of a hexagonal grid begin at 0,
// even ones half a step to the right.
struct Grid {
  bool hexagonal = false;
  double x_step = 0, y_step = 0;             // µm
  std::int64_t odd = 0, even = 0, rows = 0;  // points of odd and even rows, number of rows
  std::int64_t count() const { return (rows + 1) / 2 * odd + rows / 2 * even; }
};
// Throws Error "unreadable-file" if the grid is empty, or too large for a map (2³¹ pixels).
void check_grid(const Grid&, const Lines&);

// Makes square pixels of the points.
EbsdMap rasterize(const Grid&, std::vector<MapPoint> points, std::vector<Phase> phases, const Lines&);

}  // namespace terrazzo::load_ebsd
