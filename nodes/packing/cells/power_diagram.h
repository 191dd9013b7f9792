// Periodic power diagrams (Laguerre tessellations).
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/packing/cells/convex_cell.h"
#include "runtime/work.h"

namespace terrazzo::tessellation {

// Seeds in the periodic box [0, box). The cell of seed i holds the points x with the smallest
// |x − position_i|² − weight_i.
struct Seeds {
  Vec3 box = Vec3::Zero();     // mm
  std::vector<Vec3> position;  // mm, inside the box
  std::vector<double> weight;  // mm²
  std::size_t count() const { return position.size(); }
};

// The cell of each seed. A seed with too small a weight has an empty cell, without corners. The cells fill
// the box. Same bits for any number of threads.
std::vector<ConvexCell> power_diagram(const Seeds& seeds, const Work& work = {});

// What the computation of weights needs of a diagram.
struct CellSizes {
  struct Coupling {
    std::int32_t a, b;
    double rate;  // ∂V_a/∂w_b = −rate (mm³/mm²): area / (2 · distance of the seeds)
  };
  std::vector<double> volume;       // mm³; 0: the cell is empty
  std::vector<Vec3> centroid;       // mm, relative to the seed
  std::vector<Coupling> couplings;  // both (a, b) and (b, a), in order of a
  std::size_t empty = 0;
};
CellSizes cell_sizes(const Seeds& seeds, const Work& work = {});

}  // namespace terrazzo::tessellation
