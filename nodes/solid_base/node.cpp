#include "graph/node_type.h"
#include "nodes/solid_base/solid_base.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  SolidBase out;
  out.request = solid_optimize::read_request(c, "local");
  const auto& [exemplars, settings, voxel] = out.request;
  solid_optimize::check_request(c, out.request, solid_optimize::base_forecast(exemplars, settings));
  out.base = solid_optimize::solid_base(exemplars, settings, c.work());
  c.metric("levels", static_cast<double>(out.base.statistics.size()));
  c.metric("voxel", voxel);
  c.output("base", std::move(out));
}

}  // namespace

NodeType solid_base_node() {
  NodeType type = NodeType("SolidBase", 1)
                      .doc_(
                          "Prepares a solid texture that is too large for memory: makes its coarse levels "
                          "and measures the statistics that all blocks made by SolidBlock share")
                      .source_("See SolidOptimize, method local");
  solid_optimize::declare_exemplars(type).output("base", "SolidBase", "Data that all blocks share");
  solid_optimize::declare_settings(solid_optimize::declare_size(type)).compute_(compute);
  return type;
}

}  // namespace terrazzo
