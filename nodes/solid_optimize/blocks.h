// One block of a solid that need never be there whole.
#pragma once

#include <vector>

#include "nodes/solid_optimize/local_level.h"

namespace terrazzo::solid_optimize {

// The block that the settings name, closed along axes that are not cut.
LocalBox block_box(const SolidSettings&);

// Makes it from `families` and out.field, the finest level that is made whole. What it is does not depend on
// how the solid is cut.
void by_blocks(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&,
               std::vector<MatchFamily> families, const SolidSettings&, LocalGl*, SolidResult& out,
               const Work&);

}  // namespace terrazzo::solid_optimize
