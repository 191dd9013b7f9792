// Outlines of sections, measured alike in profiles and in the shapes of a family.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape_families {

// Circularity 4πA/P², aspect, and the degrees turned within the sharpest 24th of the outline.
constexpr std::size_t kFeatures = 3;
using Features = std::array<double, kFeatures>;

// Outlines are blurred before they are measured, so that pixels and frayed segmentations do not count as
// shape. The blur is one of these shares of the outline's length; coarser profiles need more.
constexpr std::array<double, 6> kBlur = {0.01, 0.014, 0.02, 0.028, 0.036, 0.05};

struct MeasuredProfile {
  std::size_t level = 0;  // index into kBlur
  Features features{};
};

// Nothing if the profile is cut by the border, has no outline, or is too coarse for the largest blur.
std::optional<MeasuredProfile> measured(const Profile&);

// Random sections of a family's particles, all scaled to size 1.
struct FamilySections {
  std::vector<double> ratio;    // √(4A/π) of each profile; the particle's own size is 1
  std::vector<double> natural;  // size of the particle as given, relative to the family's mean by number
  std::array<std::vector<Features>, kBlur.size()> features;
};

// Particles have the family's shapes by number. Throws Error "no-shapes", "bad-probabilities".
FamilySections family_sections(const Shapes&, std::size_t count, std::uint64_t seed, const Work&);

}  // namespace terrazzo::shape_families
