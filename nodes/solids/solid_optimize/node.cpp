#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/gl/open_gl.h"
#include "nodes/solids/synthesis/outputs.h"
#include "nodes/solids/synthesis/request.h"

namespace terrazzo {
namespace {
using namespace solids;

void check(const NodeParameters& p) {
  const auto method = p.choice<SolidMethod>("method");
  if (method == SolidMethod::Reference && p.boolean("sources"))
    throw Error("not-with-reference", "method reference cannot record sources", "set method: coherence")
        .parameter("sources");
  if (method != SolidMethod::Blockwise && p.choice<Device>("device") == Device::Gl)
    throw Error("bad-value", fmt::format("device gl needs method blockwise; method is {}", p.text("method")),
                "set method: blockwise, or device: cpu")
        .parameter("device");
}

void compute(Context& c) {
  const auto method = c.choice<SolidMethod>("method");
  SolidRequest request = read_request(c, method);
  SolidOptions& s = request.settings;
  s.sources = !c.list("features").empty() || c.boolean("sources");
  if (method == SolidMethod::Reference && s.sources)
    throw Error("not-with-reference", "method reference cannot carry features", "set method: coherence")
        .parameter("method");
  check_request(c, request, memory_forecast(request.exemplars, s));
  SolidResult r;
  {
    const auto gl = s.method == SolidMethod::Blockwise ? open_device(c) : nullptr;
    r = optimize_solid(request.exemplars, s, c.work().part(0, 0.97), gl.get());
  }
  give_solid(c, std::move(r), request.exemplars, true, request.voxel, c.work().part(0.97, 1));
}

}  // namespace

NodeType solid_optimize_node() {
  NodeType type = NodeType("SolidOptimize", 8)
                      .doc_(
                          "Synthesizes a tileable solid texture whose slices look like the exemplars: wood, "
                          "marble, meat and other materials without particles")
                      .source_(
                          "Kopf et al. 2007; Laursen, Ersbøll, Bærentzen 2011; coherence search after Tong "
                          "et al. 2002 and Barnes et al. 2009");
  declare_solid(declare_exemplars(type));
  declare_size(type).parameter(
      Parameter::choice("method", "coherence", {"coherence", "blockwise", "reference"})
          .word_was("local", "blockwise")
          .word_was("papers", "reference")
          .doc_("coherence: tries neighbors' matches, similar patches and random patches, and prefers rarely "
                "used ones. blockwise: makes the finer levels with passes that see only a bounded "
                "neighborhood, "
                "so that they can run in blocks (SolidBase) and on a GPU. reference: the method of "
                "2011, for comparison; 128³ voxels take minutes."));
  declare_settings(declare_sources(declare_device(type))).check_(check).compute_(compute);
  return type;
}

}  // namespace terrazzo
