// Solid textures from pictures of their sections: texture optimization, coarse to fine.
#pragma once

#include <vector>

#include "nodes/solids/synthesis/options/solid_options.h"
#include "nodes/solids/synthesis/whole/result.h"
#include "runtime/work.h"

namespace terrazzo::solids {

class BlockGl;
struct BlockBase;

// Exemplars must have the scale of the solid: a pixel is a voxel. The whole solid tiles. Throws Error
// "exemplar-too-small", "one-color", and "bad-value" if a blockwise solid has only one level. `gl`, if set,
// makes a blockwise solid's finer levels; it must have been made on this thread.
SolidResult optimize_solid(const std::vector<SolidExemplar>&, const SolidOptions&, const Work&,
                           BlockGl* gl = nullptr);

// A blockwise solid in two steps: the data that all blocks share (blocks.h), then the block that the settings
// name. Exemplars and settings must be the same except for the block. The blocks are those of the solid that
// optimize_solid makes.
BlockBase solid_base(const std::vector<SolidExemplar>&, const SolidOptions&, const Work&);
SolidResult solid_block(const std::vector<SolidExemplar>&, const SolidOptions&, const BlockBase&, const Work&,
                        BlockGl* gl = nullptr);

// The number of levels that optimize_solid uses for `levels` = 0.
int natural_levels(const std::vector<SolidExemplar>&, const Vec3i& size);
// Peak memory in bytes, within about a tenth: for a whole solid, and for the two steps of a blockwise one.
double memory_forecast(const std::vector<SolidExemplar>&, const SolidOptions&);
double base_forecast(const std::vector<SolidExemplar>&, const SolidOptions&);
double block_forecast(const std::vector<SolidExemplar>&, const SolidOptions&);

}  // namespace terrazzo::solids
