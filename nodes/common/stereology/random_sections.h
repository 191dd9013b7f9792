// Random plane sections of single bodies.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/geometry/mesh/mesh_section.h"
#include "runtime/work.h"

namespace terrazzo {

enum class SectionKind {
  Central,  // through the centroid, isotropic
  Random,   // isotropic uniform random: uniform over all planes that intersect the body, as in a polished
            // section
};

struct RandomSections {
  SectionKind kind = SectionKind::Random;
  std::uint64_t seed = 1;
  std::uint64_t first = 0;  // index of the first section; later indices of the same seed are further samples
};

// One section: its disjoint profiles, each with an outer loop first, then its holes.
using BodySection = std::vector<std::vector<Loop>>;

// Draws `count` random sections of bodies with probabilities by number. A central section selects a body by
// its probability, a random section by probability × mean caliper diameter, as random planes hit them. Every
// section has at least one profile. Throws Error "no-shapes" for an empty set, "bad-probabilities",
// "no-section".
std::vector<BodySection> random_sections(const Shapes&, std::size_t count, const RandomSections&,
                                         const Work& = {});

// A rotation whose last column is `direction`.
Mat3 frame_about(const Vec3& direction);

}  // namespace terrazzo
