#include "graph/node_type.h"
#include "nodes/media/annealing/media_base.h"
#include "runtime/context.h"
#include "runtime/memory.h"

namespace terrazzo::media_base {
namespace {
using namespace annealing;

void compute(Context& c) {
  MediaBase out{read_request(c), {}};
  require_memory(coarse_forecast(out.request.options.size), c.memory(), "the base");
  out.coarse = synthesize_coarse(out.request.maps, out.request.options, c.work());
  c.metric("stride", out.coarse.stride);
  c.output("base", std::move(out));
}

}  // namespace
}  // namespace terrazzo::media_base

namespace terrazzo {

NodeType media_base_node() {
  using namespace media_base;
  NodeType type =
      NodeType("MediaBase", 1)
          .doc_(
              "Prepares a solid of phases that is too large for memory: makes the coarse levels that all "
              "blocks made by MediaBlock share")
          .source_("See MediaSolid");
  declare_pictures(type).output("base", "MediaBase", "Data that all blocks share");
  declare_settings(type, kLeastEdge).compute_(compute);
  return type;
}

}  // namespace terrazzo
