#include <algorithm>
#include <optional>

#include "graph/node_type.h"
#include "nodes/volumes/blocks/block_grids.h"
#include "nodes/volumes/join_volumes/join_volumes.h"
#include "runtime/context.h"
#include "runtime/memory.h"

namespace terrazzo::join_volumes {
namespace {

void compute(Context& c) {
  const std::size_t count = c.count("volumes");
  blocks::BlockGrids grids(count);
  std::optional<Joiner> joiner;
  double bytes = 0, first = 0;
  for (std::size_t k = 0; k < count; ++k) {
    c.work().check();
    const Value value = c.nth("volumes", k);
    const Volume& block = value.as<Volume>();
    grids.add(block);
    bytes += bytes_of(block);
    if (k == 0) first = bytes;
    // Refused before the first block is copied, if the others are as large.
    require_memory(std::max(bytes, first * count), c.memory(), "the joined volume");
    if (!joiner) joiner.emplace(block);
    joiner->add(block);
    c.work().done(k + 1, count);
  }
  const blocks::Box whole = grids.whole(c.boolean("periodic"));
  Volume out = joiner->take();
  if (c.boolean("periodic")) {
    out.resolution = whole.size;
  } else {
    out.first = whole.low;
    out.extent = whole.size;
  }
  c.metric("blocks", count);
  c.metric("voxels", whole.size.cast<double>().prod());
  c.output("volume", std::move(out));
}

}  // namespace
}  // namespace terrazzo::join_volumes

namespace terrazzo {

NodeType join_volumes_node() {
  using namespace join_volumes;
  return NodeType("JoinVolumes", 2)
      .doc_(
          "Joins the blocks of a solid into one volume. The result equals, bit for bit, the volume computed "
          "in one piece.")
      .source_("None: copies voxels")
      .input_list(
          "volumes", {"Volume"},
          "The blocks, in any order: all blocks of one cut, each once, with equal grids. Every voxel of "
          "a block has a value.")
      .one_at_a_time()
      .output("volume", "Volume", "The grids of the blocks, with the voxels of all of them")
      .parameter(Parameter::boolean("periodic", true)
                     .doc_("The joined volume tiles. Its voxels must then begin at (0, 0, 0)."))
      .compute_(compute);
}

}  // namespace terrazzo
