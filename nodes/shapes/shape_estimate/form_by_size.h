// How many particles of each size are lobed, from the sizes and forms of profiles.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/shapes/shape_estimate/section_sample.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

struct SeenProfile {
  double size = 0;  // √(4·A/π), mm
  double weight = 1;
  bool lobed = false;
};

// Of all particles of a size, lobed ones have the share 1 / (1 + e^−t), where t = level + trend·ln(size /
// middle).
struct LobedShare {
  bool any = false;  // false: the profiles do not tell large lobed particles apart
  double level = 0, trend = 0;
  double middle = 1;  // mm
};

// A profile of each size is lobed or not, and a particle of each size shows both by the sections of its
// bodies, seen as the photograph shows them. Expectation and maximization find the number of particles of
// each size and the share of lobed ones together (Dempster, Laird, Rubin 1977). One profile in ten may be
// lobed because particles touch. Lobed particles must raise the log likelihood by 3, and a share that grows
// with the size must explain the profiles better than an even one by a test at 5 %: groups of the same sizes
// are one. `compact`, `lobed`: bodies with their probabilities within the group. The profiles are all that
// are as large as the smallest of them.
LobedShare lobed_share(const std::vector<SeenProfile>&, const std::vector<Shape>& compact,
                       const std::vector<Shape>& lobed, const ProfileMeasuring&, const Work& = {});

}  // namespace terrazzo::shape_estimate
