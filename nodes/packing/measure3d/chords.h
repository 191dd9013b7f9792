// Lengths of the chords of phases along the axes.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "nodes/packing/measure3d/classes.h"

namespace terrazzo::measure3d {

// The chords of one phase along one axis: the longest segments of lines inside it. All chords count equally.
struct ChordLengths {
  double mean = NAN;  // mm; NaN if no end of a chord is seen
  // Share of the chords that are k voxels long, at k. The rest to 1 is longer than any whose end is seen.
  std::vector<double> share;
};

// By class and axis. Lines of a periodic volume wrap; one entirely inside has no chord.
//
// In volumes that do not tile, chords cut by the border would be missing or too short, and long ones are cut
// more often. The mean is therefore the phase's length divided by half of its ends, both per length of the
// lines, in which no chord needs to be complete (Underwood 1970). The distribution is the product-limit
// estimate (Kaplan and Meier 1958) from the chords of which one end is seen: how many of those that are seen
// to continue for k − 1 voxels end after k. It is right because the distance to the border says nothing of
// the length.
std::vector<std::array<ChordLengths, 3>> chord_lengths(const Classes&, const Work&);

}  // namespace terrazzo::measure3d
