// The grid that the points of a map lie on, found from their coordinates.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/load_ebsd/map_text.h"

namespace terrazzo::load_ebsd {

// Rows of points. Every second row of a staggered (hexagonal) grid is shifted right by half a step.
struct Grid {
  bool staggered = false;
  bool transposed = false;        // rows are columns of the map: x and y are exchanged
  double x_step = 0, y_step = 0;  // µm, between the points of a row and between rows
  std::int64_t rows = 0;
  int first_shift = 0;               // 1: the first row is shifted
  std::int64_t columns[2] = {0, 0};  // of rows that are not shifted, and of shifted ones
  std::int64_t width = 0;            // of a row in `points`
  std::vector<std::int32_t> points;  // index of the point at each place, −1: none
  std::int64_t missing = 0;          // places without a point

  int shift(std::int64_t row) const { return staggered ? static_cast<int>((row + first_shift) % 2) : 0; }
};

// Finds the grid from the coordinates, in whatever order the points are and wherever it begins. What the
// header says must agree. Throws Error "malformed-row" with the first line that contradicts it or is not on
// the grid, "unreadable-file" if the points do not reach as far as the header says or are too few for their
// grid, "too-large".
Grid find_grid(const PointList&, const GridHeader&, std::uint64_t memory, const Lines&);

// Makes square pixels of the points. Pixels without a point are not indexed.
EbsdMap rasterize(const Grid&, const PointList&, std::vector<Phase> phases, std::uint64_t memory,
                  const Lines&);

}  // namespace terrazzo::load_ebsd
