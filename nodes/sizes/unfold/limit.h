// How much the densities depend on the smallest profiles, near the limit of the photograph's resolution.
#pragma once

#include <optional>

#include "nodes/sizes/unfolding/unfold.h"

namespace terrazzo::unfold {

struct LimitSensitivity {
  double share = 0;   // of N_V in the smallest visible class
  double change = 0;  // relative change of N_V of the other classes if the smallest class's profiles are left
                      // out of the fit
};

// Fits again without the profiles of the smallest visible class. Nothing if fewer than three classes are
// visible, no particles were found, or the remaining profiles cannot be unfolded.
std::optional<LimitSensitivity> limit_sensitivity(const Profiles&, const KMatrix&,
                                                  const unfolding::UnfoldOptions&,
                                                  const unfolding::UnfoldResult&, const Work&);

}  // namespace terrazzo::unfold
