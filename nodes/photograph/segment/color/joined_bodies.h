// Bodies of color that join several particles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/segment/color/lab_image.h"
#include "nodes/photograph/segment/network/instances.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// For each of the labels from 1 to `count` (0: binder), one per pixel: whether the body joins particles that
// lie so close that blur fills the gaps between them. At least two of the instances must lie in it side by
// side, and what they leave of it must have a color between theirs and the binder's, at least a third of the
// way, and be narrower than they are. So the lobes of one grain are not taken for particles, and neither are
// light specks in a dark pore.
std::vector<bool> joined_bodies(const LabImage&, const std::vector<std::int32_t>& labels, std::int32_t count,
                                const std::vector<Instance>&, const Work&);

}  // namespace terrazzo::segment
