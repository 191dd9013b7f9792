// Plane sections of a packing: image, labels and exact profiles.
#pragma once

#include <functional>

#include "nodes/bodies/cutting/planes.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/table.h"
#include "nodes/detail/residual/camera_noise.h"
#include "nodes/detail/residual/residual_field.h"
#include "runtime/work.h"

namespace terrazzo::section {

struct Section {
  Image image;        // particle colors over the binder color with detail, antialiased by exact coverage
  Labels labels;      // profile k of `profiles` is id k + 1
  Profiles profiles;  // one per connected region
  Table table;        // one row per profile: section, particle, class, area mm², perimeter mm, holes, weight
  double overlap = 0;  // area covered by more than one particle / total area
};

// Cuts the particles of a periodic box. In a tile (axis planes), every profile is whole and has weight 1. In
// a window, profiles cut by the border have weight 0 and the area and outline of their visible part. Other
// profiles have the weight window area / (area in which a profile of their width and height is entirely
// visible), after Miles (1974) and Lantuéjoul (1978). `detail` may be null; without it, the camera is not
// used. `flat` receives the picture of a single section before its detail is added. Throws the errors of
// check_particles.
Section cut_section(const Particles&, const Shapes&, const SectionLayout&, const Work& = {},
                    const residual::ResidualField* detail = nullptr, const residual::Camera& = {},
                    const std::function<void(const Image&)>& flat = {});

}  // namespace terrazzo::section
