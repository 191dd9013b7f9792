// The shapes of one class of profiles, by the method that ShapeEstimate's parameters name.
#pragma once

#include <cstddef>
#include <vector>

#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/shapes/shape_estimate/choose.h"
#include "runtime/context.h"

namespace terrazzo::shape_estimate {

inline constexpr std::size_t kFitLeast = 12;
inline constexpr std::size_t kFitEnough = 24;  // usable profiles

struct ClassEstimate {
  std::vector<Shape> shapes;  // the probabilities sum to 1
  std::size_t usable = 0;     // number of usable profiles
  double triangles = 0, self_intersections = 0;
  double deviation = -1;                      // of the methods that report one, otherwise −1
  double lobed = 0;                           // share of lobed particles at the middle size
  double start_distance = -1, distance = -1;  // of method fit, otherwise −1
};

// Reads the parameters of the node and warns about what is wrong with its shapes. Throws Error
// "too-few-profiles", "bad-profile", "no-start".
ClassEstimate estimate_class(Context&, const Profiles&, const CandidateOptions&, const Work&);

}  // namespace terrazzo::shape_estimate
