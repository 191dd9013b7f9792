// Cells that cover a canvas: a power diagram (Aurenhammer 1987).
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "nodes/photograph/synthetic_photo/canvas.h"
#include "runtime/work.h"

namespace terrazzo::synthetic_photo {

struct CellSeed {
  double x, y, weight;
  bool binder;

  double power(double px, double py) const {
    const double dx = px - x, dy = py - y;
    return dx * dx + dy * dy - weight;
  }
};

// Makes the cells' borders wavy.
struct CellWarp {
  double amount = 0, size = 1;  // canvas pixels
  std::uint64_t seed = 0;
};

// Where a pixel is in the diagram.
struct CellPlace {
  int x, y;
  std::size_t first, second;  // its cell, and the one across the nearest border
  double to_border;           // canvas pixels
};

void visit_cells(const Canvas&, const std::vector<CellSeed>&, const CellWarp&, const Work&,
                 const std::function<void(const CellPlace&)>&);

}  // namespace terrazzo::synthetic_photo
