// Random plane sections of single bodies.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/mesh_section.h"
#include "runtime/work.h"

namespace terrazzo {

enum class SectionKind {
  Central,  // through the centroid, any orientation alike
  Random,   // isotropic uniform random: any plane that meets the body alike, as a polished face shows it
};

struct RandomSections {
  SectionKind kind = SectionKind::Random;
  std::uint64_t seed = 1;
  std::uint64_t first = 0;  // number of the first section: further ones of a seed are further samples
};

// One section: its disjoint profiles, each an outer loop first, then its holes.
using BodySection = std::vector<std::vector<Loop>>;

// `count` random sections of bodies given with their shares by number. A central section takes a body by its
// share; a random one by share × mean caliper, as planes meet them. Every section shows something. Throws
// Error "no-shapes" for an empty set.
std::vector<BodySection> random_sections(const Shapes&, std::size_t count, const RandomSections&,
                                         const Work& = {});

// A rotation whose last column is a direction.
Mat3 frame_about(const Vec3& direction);

}  // namespace terrazzo
