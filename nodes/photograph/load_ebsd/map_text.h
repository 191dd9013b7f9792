// What the readers of both formats share: lines, numbers and points.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nodes/photograph/load_ebsd/ebsd_map.h"

namespace terrazzo::load_ebsd {

// The lines of a text, numbered from 1, without their ends.
class Lines {
 public:
  Lines(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}
  bool next(std::string_view& line);
  void back() {
    at_ = before_;
    --number_;
  }                                       // to read the last line again
  int number() const { return number_; }  // of the line that was read last
  // Throws Error "malformed-row" with the file and the line that was read last, or with one that contradicts
  // the header or others, or "unreadable-file".
  [[noreturn]] void malformed(const std::string& what) const;
  [[noreturn]] void contradiction(int line, const std::string& what) const;
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
// The unit of the last digit of a number as it is written: 0.01 for "2.50", 1 for "7".
double last_digit(std::string_view number);

// A number of the header, with the unit of its last digit.
struct HeaderNumber {
  double value = 0, digit = 0;
};

// What the header says about the grid of points. The coordinates must agree with all of it.
struct GridHeader {
  std::optional<bool> hexagonal;
  // µm. Of a hexagonal grid: between the points of a row, and between rows. Negative if coordinates descend.
  std::optional<HeaderNumber> x_step, y_step;
  // Points of the 1st, 3rd … row and of the 2nd, 4th …, and number of rows.
  std::optional<std::int64_t> odd, even, rows;
  // What messages call the steps and counts.
  const char *x_step_name = "XSTEP", *y_step_name = "YSTEP";
  const char *columns_name = "NCOLS_ODD and NCOLS_EVEN", *rows_name = "NROWS";
};

// The points of a file in its order.
struct PointList {
  std::vector<MapPoint> points;
  std::vector<double> x, y;        // µm
  std::vector<std::int32_t> line;  // of each point
  double x_digit = 1,
         y_digit = 1;  // µm: unit of the last digit of the coordinates, the smallest of all points

  void add(const MapPoint&, std::string_view x, std::string_view y, double unit, const Lines&);
};

// The points of the lines that follow: `add` gets the cells of each line that is not blank. Throws Error
// "unreadable-file" if there is no point.
PointList read_points(Lines&,
                      const std::function<void(const std::vector<std::string_view>& cells, PointList&)>& add);

}  // namespace terrazzo::load_ebsd
