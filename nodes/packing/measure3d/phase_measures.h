// Everything that is measured of single phases of a volume.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "nodes/packing/measure3d/chords.h"
#include "nodes/packing/measure3d/minkowski.h"
#include "nodes/packing/measure3d/percolation.h"
#include "nodes/packing/measure3d/thickness.h"

namespace terrazzo::measure3d {

struct PhaseMeasures {
  std::string name;     // as in Classes
  double fraction = 0;  // of the volume
  MinkowskiDensities densities;
  std::array<ChordLengths, 3> chords;  // along x, y, z
  Vec3 spacing = Vec3::Ones();         // of the voxels, mm
  ThicknessDistribution thickness;     // unknown unless wanted
  Percolation percolation;
};

// One entry per class. Throws Error "too-large" beyond `memory` bytes.
std::vector<PhaseMeasures> measure_classes(const Classes&, std::uint64_t memory, const Work&);

}  // namespace terrazzo::measure3d
