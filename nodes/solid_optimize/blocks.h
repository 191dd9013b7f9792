// Single blocks of a solid that is never held in memory as a whole.
#pragma once

#include <vector>

#include "nodes/solid_optimize/local_level.h"

namespace terrazzo::solid_optimize {

// The block that the settings name. It is closed along axes that are not cut.
LocalBox block_box(const SolidSettings&);

// The data shared by all blocks of a local solid.
struct LocalBase {
  WholeLevel whole;  // its field is empty
  std::vector<LevelStatistics> statistics;
};

// Both start from the finest level that is made whole: out.field as by_coherence leaves it, and `families`.
// measure_base makes the shared base only; make_block makes a block and its measures. A block does not depend
// on how the solid is cut.
LocalBase measure_base(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&,
                       std::vector<MatchFamily> families, const SolidSettings&, SolidResult& out,
                       const Work&);
void make_block(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&, const LocalBase&,
                const SolidSettings&, LocalGl*, SolidResult& out, const Work&);
// Both steps together.
void make_block(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&,
                std::vector<MatchFamily> families, const SolidSettings&, LocalGl*, SolidResult& out,
                const Work&);

}  // namespace terrazzo::solid_optimize
