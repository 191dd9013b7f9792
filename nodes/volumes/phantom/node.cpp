#include <algorithm>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/volumes/phantom/phantom.h"
#include "runtime/context.h"

namespace terrazzo::phantom {
namespace {

void check(const NodeParameters& p) {
  if (p.ints("resolution").size() == 2)
    throw Error("bad-resolution", "resolution must be one number, or three numbers for x, y and z",
                "write 1 or 3 numbers")
        .parameter("resolution");
}

void compute(Context& c) {
  LimbOptions limb;
  limb.length = c.number("length");
  limb.noise = c.number("noise");
  limb.seed = c.seed();
  const auto r = c.ints("resolution");
  if (r.size() == 3)
    limb.resolution = Vec3i(static_cast<int>(r[0]), static_cast<int>(r[1]), static_cast<int>(r[2]));
  else
    for (int k = 0; k < 3; ++k)
      limb.resolution[k] = std::max<int>(2, limb.box()[k] / limb.length * r[0] + 0.5);
  const std::vector<float> values = phantom::limb(limb, c.work().part(0, 0.9));
  Volume volume;
  add_number_grid(volume, "density", limb.resolution, limb.spacing(), c.work().part(0.9, 1),
                  [&](std::size_t i) { return values[i]; });
  volume.extent = limb.resolution;
  c.output("volume", std::move(volume));
}

}  // namespace
}  // namespace terrazzo::phantom

namespace terrazzo {

NodeType phantom_node() {
  using namespace phantom;
  return NodeType("Phantom", 2)
      .doc_("Makes a synthetic scan of a limb in Hounsfield units, with skin, fat, muscles and bones")
      .output("volume", "Volume", "Grid `density` in Hounsfield units. The limb is cut at z = 0.")
      .parameter(
          Parameter::ints("resolution", {120})
              .count(1, 3)
              .range(2, 2048)
              .unit_("voxels")
              .doc_("Voxels along the limb, or along x, y and z. Three numbers can stretch the voxels."))
      .parameter(Parameter::number("length", 240)
                     .range(1e-9, 1e9)
                     .unit_("mm")
                     .doc_("Length of the limb. Its width and depth are two thirds of that."))
      .parameter(Parameter::number("noise", 8)
                     .range(0, 1000)
                     .doc_("Standard deviation of each voxel in Hounsfield units"))
      .parameter(Parameter::seed())
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
