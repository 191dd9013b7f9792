#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "graph/node_type.h"
#include "nodes/solid_optimize/from_context.h"
#include "nodes/solid_optimize/give_solid.h"

namespace terrazzo {
namespace {
using namespace solid_optimize;

void compute(Context& c) {
  const std::string method = c.text("method");
  SolidRequest request = read_request(c, method);
  SolidSettings& s = request.settings;
  s.sources = !c.list("features").empty() || c.boolean("sources");
  if (s.papers && s.sources)
    throw Error("not-with-papers",
                "method papers, the reference method of 2011, cannot carry sources or features",
                "set method: coherence")
        .parameter("method");
  if (!s.local && c.text("device") == "gl")
    throw Error("bad-value", fmt::format("device gl needs method local; method is {}", method),
                "set method: local, or device: cpu")
        .parameter("device");
  check_request(c, request, memory_forecast(request.exemplars, s));
  SolidResult r;
  {
    const auto gl = s.local ? open_device(c) : nullptr;
    r = optimize_solid(request.exemplars, s, c.work().part(0, 0.97), gl.get());
  }
  give_solid(c, std::move(r), request.exemplars, true, request.voxel, c.work().part(0.97, 1));
}

}  // namespace

NodeType solid_optimize_node() {
  NodeType type = NodeType("SolidOptimize", 7)
                      .doc_(
                          "Synthesizes a tileable solid texture whose slices look like the exemplars: wood, "
                          "marble, meat and other materials without particles")
                      .source_(
                          "Kopf et al. 2007; Laursen, Ersbøll, Bærentzen 2011; coherence search after Tong "
                          "et al. 2002 and Barnes et al. 2009");
  declare_solid(declare_exemplars(type));
  declare_size(type).parameter(
      Parameter::choice("method", "coherence", {"coherence", "local", "papers"})
          .doc_("coherence: tries neighbors' matches, similar patches and random patches, and prefers rarely "
                "used ones. local: makes the finer levels with passes that see only a bounded neighborhood, "
                "so that they can run in blocks (SolidBase) and on a GPU. papers: the reference method of "
                "2011, for comparison; 128³ voxels take minutes."));
  declare_settings(declare_sources(declare_device(type))).compute_(compute);
  return type;
}

}  // namespace terrazzo
