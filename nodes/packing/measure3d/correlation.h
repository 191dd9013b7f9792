// Two-point correlation and lineal path of a phase in a volume (Torquato 2002, 2.1 and 2.4).
#pragma once

#include <array>
#include <vector>

#include "nodes/packing/measure3d/raster.h"

namespace terrazzo::measure3d {

// Entry k belongs to the distance k · step.
struct Correlation {
  double step = 0;  // the shortest edge of a voxel, mm
  // S2: probability that both ends of a segment are in the phase, by axis. L: that the whole segment is.
  // Between whole voxels, linear interpolation.
  std::array<std::vector<double>, 3> two_point, lineal_path;
  // Means of S2 over all segments whose length is within half a step of k · step, and their mean length, mm.
  std::vector<double> mean, length;
};

// Up to half of the shortest edge of the box. A periodic volume wraps; otherwise all segments inside the box
// count equally. Throws Error "too-large" if the transform needs more than `memory` bytes.
Correlation correlate(const Raster&, std::uint64_t memory, const Work&);

}  // namespace terrazzo::measure3d
