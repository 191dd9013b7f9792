// One block of a solid that need never be there whole.
#pragma once

#include <vector>

#include "nodes/solid_optimize/local_level.h"

namespace terrazzo::solid_optimize {

// The block that the settings name, closed along axes that are not cut.
LocalBox block_box(const SolidSettings&);

// What all blocks of a local solid share.
struct LocalBase {
  WholeLevel whole;  // its field is empty
  std::vector<LevelStatistics> statistics;
};

// From the finest level that is made whole: out.field as by_coherence leaves it, and `families`. The base
// alone; or a block, with what is measured of it. What a block is does not depend on how the solid is cut.
LocalBase measure_base(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&,
                       std::vector<MatchFamily> families, const SolidSettings&, SolidResult& out,
                       const Work&);
void make_block(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&, const LocalBase&,
                const SolidSettings&, LocalGl*, SolidResult& out, const Work&);
// Both at once.
void make_block(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&,
                std::vector<MatchFamily> families, const SolidSettings&, LocalGl*, SolidResult& out,
                const Work&);

}  // namespace terrazzo::solid_optimize
