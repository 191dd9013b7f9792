#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/media/annealing/phase_grid.h"
#include "nodes/media/annealing/request.h"
#include "runtime/context.h"
#include "runtime/memory.h"

namespace terrazzo::media_solid {
namespace {
using namespace annealing;

void compute(Context& c) {
  const PhaseRequest request = read_request(c);
  const Vec3i& size = request.options.size;
  if (size.cast<double>().prod() > kMostVoxels)
    throw Error("too-large", fmt::format("{} × {} × {} voxels are too many", size.x(), size.y(), size.z()),
                fmt::format("make at most {:.0f} voxels; the solid tiles", kMostVoxels))
        .parameter("size");
  require_memory(memory_forecast(size), c.memory(), "the solid");
  const Solid solid = synthesize(request.maps, request.options, c.work().part(0, 0.93));
  give_agreement(c, request, solid, c.work().part(0.93, 0.97));
  c.output("volume", phase_volume(solid.phase, size, request.maps[0].pixel_size, request.color, {},
                                  c.work().part(0.97, 1)));
}

}  // namespace
}  // namespace terrazzo::media_solid

namespace terrazzo {

NodeType media_solid_node() {
  using namespace media_solid;
  NodeType type =
      NodeType("MediaSolid", 2)
          .doc_(
              "Makes a tileable solid of phases whose slices show the same patterns as one to three pictures")
          .source_("Deutsch 1992; Peredo and Ortiz 2011; Yeong and Torquato 1998");
  declare_pictures(type).output(
      "volume", "Volume",
      "Solid that tiles: grid `phase`, the number of each voxel's phase, and `Cd`, its mean color in the "
      "image");
  declare_settings(declare_agreement(type), 16).compute_(compute);
  return type;
}

}  // namespace terrazzo
