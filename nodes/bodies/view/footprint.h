// What stones cover in a map of heights, seen along z.
#pragma once

#include <Eigen/Core>

#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/data/linear.h"

namespace terrazzo::view {

using CellMap = Eigen::ArrayXXf;  // mm; (x, y), y upwards

// Square cells over a picture whose lower left corner is the origin.
struct CellGrid {
  double cell = 1;            // mm, edge of a cell
  int width = 0, height = 0;  // cells

  double column(double x) const { return x / cell; }
  double row(double y) const { return y / cell; }
};

// A rectangle of cells.
struct Cells {
  int x = 0, y = 0, width = 0, height = 0;

  bool empty() const { return width <= 0 || height <= 0; }
  Cells within(const CellGrid&) const;
};

// The highest surface of a stone at the center of each cell, mm above the stone's origin.
struct Footprint {
  Cells cells;   // in the grid, and beyond its border
  CellMap high;  // −∞ where the stone isn't
};

// The cell of the highest corner has it, too, so that no stone is without cells.
Footprint footprint_of(const carving::RayScene::Triangles&, const carving::RayScene::Instance&,
                       const CellGrid&);

}  // namespace terrazzo::view
