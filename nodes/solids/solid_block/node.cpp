#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "graph/node_type.h"
#include "nodes/common/geometry/one_or_three.h"
#include "nodes/solids/synthesis/outputs.h"
#include "nodes/solids/synthesis/solid_base.h"

namespace terrazzo {
namespace {
using namespace solids;

constexpr int kLeastBlock = 16;  // voxels

// Reads how the solid is cut, and which block to make.
void read_block(const Context& c, SolidOptions& s) {
  s.blocks = one_or_three(c, "blocks");
  s.block = c.integer("block");
  for (int a = 0; a < 3; ++a)
    if (s.size[a] / s.blocks[a] < kLeastBlock)
      throw Error("bad-value",
                  fmt::format("{} blocks along {} voxels are thinner than the least, {} voxels", s.blocks[a],
                              s.size[a], kLeastBlock),
                  "cut the solid into fewer blocks")
          .parameter("blocks");
  if (s.block >= s.blocks.prod())
    throw Error("bad-value",
                fmt::format("block {} does not exist: the solid has {} blocks", s.block, s.blocks.prod()),
                fmt::format("choose a block from 0 to {}, x fastest, z slowest", s.blocks.prod() - 1))
        .parameter("block");
}

void compute(Context& c) {
  const SolidBase& base = c.input<SolidBase>("base");
  if (base.request.exemplars.empty())
    throw Error("empty-base", "the base has no exemplars", "connect the output base of a SolidBase");
  SolidOptions s = base.request.settings;
  read_block(c, s);
  s.sources = c.boolean("sources");
  for (const auto& e : base.request.exemplars) s.sources |= !e.features.empty();
  const double bytes = block_forecast(base.request.exemplars, s);
  if (bytes > c.number("memory") * 1e6)
    throw Error("too-large",
                fmt::format("the block needs about {:.0f} MB; the limit is {:.0f} MB", bytes / 1e6,
                            c.number("memory")),
                "cut the solid into more blocks, or raise memory")
        .parameter("blocks");
  SolidResult r;
  {
    const auto gl = open_device(c);
    r = solid_block(base.request.exemplars, s, base.base, c.work().part(0, 0.97), gl.get());
  }
  give_solid(c, std::move(r), base.request.exemplars, s.blocks == Vec3i::Ones(), base.request.voxel,
             c.work().part(0.97, 1));
}

}  // namespace

NodeType solid_block_node() {
  NodeType type =
      NodeType("SolidBlock", 2)
          .doc_(
              "Makes one block of a solid texture that is too large for memory. Its voxels equal those of "
              "the whole solid at its place, whatever the order in which blocks are made.")
          .source_("See SolidOptimize, method blockwise")
          .input("base", "SolidBase", "Data that all blocks share");
  declare_solid(type)
      .parameter(Parameter::ints("blocks", {1})
                     .count(1, 3)
                     .range(1, 256)
                     .doc_("Number of blocks into which the solid is cut, along all axes or one number per "
                           "axis. Large blocks cost less in total, since each needs a margin."))
      .parameter(Parameter::integer("block", 0)
                     .range(0, 16777215)
                     .doc_("Block to make, counted with x fastest, z slowest"));
  declare_sources(declare_device(type))
      .parameter(Parameter::number("memory", 4000)
                     .range(1, 1e7)
                     .unit_("MB")
                     .doc_("Memory limit. Blocks that need more are refused before any work starts."))
      .compute_(compute);
  return type;
}

}  // namespace terrazzo
