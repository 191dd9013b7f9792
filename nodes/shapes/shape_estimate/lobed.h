// Lobed particles among compact ones: their profiles, and bodies that show such profiles.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/shapes/shape_estimate/outline.h"
#include "nodes/shapes/shape_estimate/section_sample.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

// Profiles less convex than this are lobed. Outlines of worn, frayed and angular grains are more convex.
inline constexpr double kLobed = 0.95;

// Which profiles show lobed particles.
struct Forms {
  std::vector<char> lobed;  // of each profile
  // Those as large as three quarters of the lobed ones, of any form: if large particles are lobed and others
  // are not, all of these show lobed particles, and the others that are not lobed show compact ones.
  std::vector<Outline> large;
  std::vector<int> not_compact;  // ids of all that are lobed or large, ascending
};

// Nothing unless at least four profiles are lobed, and one in ten, because touching particles that were not
// separated look alike, and unless these are larger than others. Profiles by decreasing area.
std::optional<Forms> forms_of(const std::vector<Outline>&, const ProfileMeasuring&);

// The `count` lobed bodies of 64 whose sections are most like the profiles, which are all above a size.
std::vector<Mesh> lobed_bodies(const std::vector<Outline>& large, const ProfileMeasuring&, int count,
                               std::uint64_t seed, const Work& = {});

}  // namespace terrazzo::shape_estimate
