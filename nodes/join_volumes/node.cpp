#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "graph/node_type.h"
#include "nodes/join_volumes/join_volumes.h"
#include "runtime/context.h"
#include "runtime/memory.h"

namespace terrazzo {
namespace {
using namespace join_volumes;

void compute(Context& c) {
  std::vector<const Volume*> blocks;
  for (const Value& v : c.list("volumes")) blocks.push_back(&v.as<Volume>());
  const Box whole = box_of(boxes_of(blocks, c.work().part(0, 0.1)));
  if (c.boolean("periodic") && whole.low != Vec3i::Zero())
    throw Error("missing-blocks",
                fmt::format("the first block begins at voxel ({}, {}, {}) instead of (0, 0, 0)",
                            whole.low.x(), whole.low.y(), whole.low.z()),
                "connect all blocks of the solid, or set periodic: false")
        .parameter("periodic");
  require_memory(joined_bytes(blocks), c.memory(), "the joined volume");
  Volume out = joined(blocks, c.work().part(0.1, 1));
  if (c.boolean("periodic")) out.resolution = whole.size;
  c.metric("blocks", static_cast<double>(blocks.size()));
  c.metric("voxels", whole.size.cast<double>().prod());
  c.output("volume", std::move(out));
}

}  // namespace

NodeType join_volumes_node() {
  return NodeType("JoinVolumes", 1)
      .doc_(
          "Joins the blocks of a solid into one volume. The result equals the volume that was made at once, "
          "bit "
          "for bit.")
      .source_("None: copies voxels")
      .input_list(
          "volumes", {"Volume"},
          "The blocks, in any order: all blocks of one cut, each once, with equal grids. Every voxel of "
          "a block has a value.")
      .output("volume", "Volume", "The grids of the blocks, with the voxels of all of them")
      .parameter(Parameter::boolean("periodic", true)
                     .doc_("The joined volume tiles. Its voxels must then begin at (0, 0, 0)."))
      .compute_(compute);
}

}  // namespace terrazzo
