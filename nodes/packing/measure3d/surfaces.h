// Areas of surfaces between labels, by counting crossings along 13 directions.
#pragma once

#include <vector>

#include "nodes/packing/measure3d/bodies.h"
#include "nodes/packing/measure3d/classes.h"

namespace terrazzo::measure3d {

// Pairs of labels that share voxel faces, with the area between them. Cauchy–Crofton: an area is twice its
// crossings per length, averaged over directions, times the volume. The directions are those from a voxel to
// its 26 neighbors, weighted by the solid angles that they are closest to (Ohser and Mücklich 2000, chapter
// 4). Volumes that do not tile have no surface at their border.
std::vector<Touch> touches_of(const Raster&, const Work&);

// Interface of two classes that share voxel faces; a < b.
struct Interface {
  std::int32_t a = 0, b = 0;  // classes
  double area = 0;            // inside the box, mm²
  double per_volume = 0;      // 1/mm; in volumes that do not tile, corrected for pairs that the border cuts
};

// In the same way, ordered by a and b.
std::vector<Interface> interfaces_of(const Classes&, const Work&);

}  // namespace terrazzo::measure3d
