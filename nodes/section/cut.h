// The exact sections of particles by planes.
#pragma once

#include "nodes/data/particles.h"
#include "nodes/section/planes.h"
#include "nodes/section/region.h"
#include "runtime/work.h"

namespace terrazzo {

// One connected region of one particle's section.
struct Cut {
  int section = 0;
  int particle = 0;
  Region region;  // mm in the window's coordinates; may stick out of the window
};

// Throws Error "no-particles", "no-shapes", "no-such-shape", "bad-particle", "bad-box" for what cannot be
// cut.
void check_particles(const Particles&, const Shapes&);

// Every region that the layout's windows show, in the order of section, particle and periodic image. In a
// tile each is there once, whole, with its centroid in the tile; in a window every periodic image counts that
// reaches into it.
std::vector<Cut> cut_particles(const Particles&, const Shapes&, const SectionLayout&, const Work& = {});

}  // namespace terrazzo
