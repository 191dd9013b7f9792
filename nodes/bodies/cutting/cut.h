// Exact plane sections of particles.
#pragma once

#include "nodes/bodies/cutting/planes.h"
#include "nodes/bodies/cutting/region.h"
#include "nodes/data/particles.h"
#include "runtime/work.h"

namespace terrazzo::section {

// One connected region of one particle's section.
struct Cut {
  int section = 0;
  int particle = 0;
  Region region;  // mm, in the window's coordinates; may extend past the window
};

// Throws Error "no-particles", "no-shapes", "no-such-shape", "bad-particle" or "bad-box" if the input cannot
// be cut.
void check_particles(const Particles&, const Shapes&);

// Every region visible in the layout's windows, ordered by section, particle and periodic image. In a tile,
// each region appears once, whole, with its centroid in the tile. In a window, every periodic image that
// reaches into the window appears.
std::vector<Cut> cut_particles(const Particles&, const Shapes&, const SectionLayout&, const Work& = {});

}  // namespace terrazzo::section
