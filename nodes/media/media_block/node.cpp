#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/media/annealing/media_base.h"
#include "nodes/media/annealing/phase_grid.h"
#include "runtime/context.h"
#include "runtime/memory.h"

namespace terrazzo::media_block {
namespace {
using namespace annealing;

void check_block(int blocks, int block, const Vec3i& size) {
  const int layers = size.z() / blocks;
  if (blocks > 1 && layers < kLeastLayers)
    throw Error("bad-value",
                fmt::format("{} blocks along {} voxels are thinner than the least, {} voxels", blocks,
                            size.z(), kLeastLayers),
                "cut the solid into fewer blocks")
        .parameter("blocks");
  if (1.0 * size.x() * size.y() * (layers + 1) > kMostVoxels)
    throw Error("too-large",
                fmt::format("blocks of {} × {} × {} voxels are too large", size.x(), size.y(), layers),
                fmt::format("cut the solid into more blocks, of at most {:.0f} voxels", kMostVoxels))
        .parameter("blocks");
  if (block >= blocks)
    throw Error("bad-value", fmt::format("block {} does not exist: the solid has {} blocks", block, blocks),
                fmt::format("choose a block from 0 to {}, along z", blocks - 1))
        .parameter("block");
}

void compute(Context& c) {
  const auto& [request, coarse] = c.input<MediaBase>("base");
  if (request.maps.empty())
    throw Error("empty-base", "the base has no pictures", "connect the output base of a MediaBase");
  const int blocks = c.integer("blocks"), block = c.integer("block");
  check_block(blocks, block, request.options.size);
  require_memory(block_forecast(request.options.size, blocks), c.memory(), "the block");
  const Solid solid =
      synthesize_block(request.maps, request.options, coarse, blocks, block, c.work().part(0, 0.93));
  const Layers layers = layers_of(blocks, block, request.options.size.z());
  PhaseRequest part = request;
  part.options.size.z() = layers.count;
  give_agreement(c, part, solid, c.work().part(0.93, 0.97));
  std::optional<Vec3i> first;
  if (blocks > 1) first = Vec3i(0, 0, layers.first);
  c.output("volume", phase_volume(solid.phase, part.options.size, part.maps[0].pixel_size, part.color, first,
                                  c.work().part(0.97, 1)));
}

}  // namespace
}  // namespace terrazzo::media_block

namespace terrazzo {

NodeType media_block_node() {
  using namespace media_block;
  NodeType type =
      NodeType("MediaBlock", 1)
          .doc_(
              "Makes one block of a solid of phases that is too large for memory: a slab across z. In any "
              "order, blocks fit together.")
          .source_("See MediaSolid")
          .input("base", "MediaBase", "Data that all blocks share")
          .output(
              "volume", "Volume",
              "The block: grid `phase`, the number of each voxel's phase, and `Cd`, its mean color in the "
              "image. All blocks together tile.");
  declare_agreement(type)
      .parameter(Parameter::integer("blocks", 1)
                     .range(1, 64)
                     .doc_("Number of blocks into which the solid is cut along z, each at least 96 voxels "
                           "thick. Another "
                           "number gives another solid. Thick blocks cost less in total, since neighbors "
                           "both make the layers "
                           "around their cut. 1: the solid of MediaSolid."))
      .parameter(Parameter::integer("block", 0).range(0, 63).doc_("Block to make, counted along z"))
      .compute_(compute);
  return type;
}

}  // namespace terrazzo
