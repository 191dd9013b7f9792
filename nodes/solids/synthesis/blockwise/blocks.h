// Single blocks of a solid that is never held in memory as a whole.
#pragma once

#include <vector>

#include "nodes/solids/synthesis/blockwise/level.h"

namespace terrazzo::solids {

// The block that the settings name. It is closed along axes that are not cut.
TorusBox block_box(const SolidOptions&);

// The data shared by all blocks of a blockwise solid.
struct BlockBase {
  WholeLevel whole;  // its field is empty
  std::vector<LevelStatistics> statistics;
};

// Both start from the finest level that is made whole: out.field as by_coherence leaves it, and `families`.
// measure_base makes the shared base only; make_block makes a block and its measures. A block does not depend
// on how the solid is cut.
BlockBase measure_base(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&,
                       std::vector<NeighborField> families, const SolidOptions&, SolidResult& out,
                       const Work&);
void make_block(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&, const BlockBase&,
                const SolidOptions&, BlockGl*, SolidResult& out, const Work&);
// Both steps together.
void make_block(const std::vector<SolidExemplar>& working, std::vector<Pyramid>&,
                std::vector<NeighborField> families, const SolidOptions&, BlockGl*, SolidResult& out,
                const Work&);

}  // namespace terrazzo::solids
