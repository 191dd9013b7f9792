#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/solids/synthesis/solid_base.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  SolidBase out;
  out.request = solids::read_request(c, solids::SolidMethod::Blockwise);
  const auto& [exemplars, settings, voxel] = out.request;
  solids::check_request(c, out.request, solids::base_forecast(exemplars, settings));
  out.base = solids::solid_base(exemplars, settings, c.work());
  c.metric("levels", out.base.statistics.size());
  c.metric("voxel", voxel);
  c.output("base", std::move(out));
}

}  // namespace

NodeType solid_base_node() {
  NodeType type = NodeType("SolidBase", 2)
                      .doc_(
                          "Prepares a solid texture that is too large for memory: makes its coarse levels "
                          "and measures the statistics that all blocks made by SolidBlock share")
                      .source_("See SolidOptimize, method blockwise");
  solids::declare_exemplars(type).output("base", "SolidBase", "Data that all blocks share");
  solids::declare_settings(solids::declare_size(type)).compute_(compute);
  return type;
}

}  // namespace terrazzo
