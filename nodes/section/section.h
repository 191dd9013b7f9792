// What plane sections of a packing show: picture, labels and exact profiles.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/table.h"
#include "nodes/section/planes.h"
#include "runtime/work.h"

namespace terrazzo {

struct Section {
  Image image;         // particles' colours over the binder's, antialiased by exact coverage
  Labels labels;       // profile k of `profiles` is id k + 1
  Profiles profiles;   // one per connected region
  Table table;         // a row per profile: section, particle, class, area mm², perimeter mm, holes, weight
  double overlap = 0;  // area that more than one particle claims / all area
};

// Cuts particles of a periodic box. In a tile (axis planes) every profile is whole, weight 1. In a window
// those that its border cuts have weight 0, their visible area and outline, and the others stand for window /
// (area in which a profile of their width and height lies whole), after Miles (1974) and Lantuéjoul (1978).
// Throws Error as check_particles does.
Section cut_section(const Particles&, const Shapes&, const SectionLayout&, const Work& = {});

}  // namespace terrazzo
