// What stones cover in a map of heights, seen along z.
#pragma once

#include <Eigen/Core>

#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/data/linear.h"

namespace terrazzo::view {

using CellMap = Eigen::ArrayXXf;  // mm; (x, y), y upwards

// Square cells over a picture whose lower left corner is the origin, and over a margin around it.
struct CellGrid {
  double cell = 1;            // mm, edge of a cell
  int margin = 0;             // cells on each side of the picture
  int width = 0, height = 0;  // cells, with the margins

  double column(double x) const { return x / cell + margin; }
  double row(double y) const { return y / cell + margin; }
};

// A rectangle of cells.
struct Cells {
  int x = 0, y = 0, width = 0, height = 0;

  bool empty() const { return width <= 0 || height <= 0; }
  bool holds(int column, int row) const {
    return column >= x && row >= y && column < x + width && row < y + height;
  }
  Cells within(const CellGrid&) const;
};

// The lowest and the highest surface of a stone at the center of each cell, mm above the stone's origin.
struct Footprint {
  Cells cells;        // in the grid, and beyond its border
  CellMap low, high;  // +∞ and −∞ where the stone isn't
  float bottom = 0;   // of the whole stone, mm above its origin
  float top = 0;      // the same
  float height() const { return top - bottom; }
};

// Cells also have the lowest and the highest corner in them, so that no stone is without cells.
Footprint footprint_of(const carving::RayScene::Triangles&, const carving::RayScene::Instance&,
                       const CellGrid&);

// Raises a map to a stone's highest surface, the stone's origin being at height z.
void lay(CellMap&, const CellGrid&, const Footprint&, float z);

}  // namespace terrazzo::view
