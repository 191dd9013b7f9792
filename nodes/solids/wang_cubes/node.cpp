#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "graph/node_type.h"
#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/geometry/one_or_three.h"
#include "nodes/data/table.h"
#include "nodes/solids/patch_fill/patch_space.h"
#include "nodes/solids/patch_fill/read_solid.h"
#include "nodes/solids/wang_cubes/wang_cubes.h"
#include "runtime/context.h"
#include "runtime/memory.h"

namespace terrazzo {
namespace {

using namespace wang_cubes;
using namespace patch_fill;

void check(const NodeParameters& p) { one_or_three(p, "cubes"); }

void compute(Context& c) {
  const Volume& volume = c.input<Volume>("solid");
  const VoxelBox box = solid_box(volume, "solid");
  CubeOptions s;
  s.colors = c.integer("colors");
  s.rim = c.integer("rim");
  s.fill.iterations.clear();
  for (const auto n : c.ints("iterations")) s.fill.iterations.push_back(static_cast<int>(n));
  s.fill.seed = c.seed();
  if (box.size.minCoeff() < 2 * s.rim + kPatch)
    throw Error("too-small",
                fmt::format("the solid's shortest edge is {} voxels; a rim of {} voxels needs {}",
                            box.size.minCoeff(), s.rim, 2 * s.rim + kPatch),
                "use a larger solid, or a smaller rim")
        .parameter("rim");
  const Lattice lattice = random_lattice(one_or_three(c, "cubes"), s.colors, c.seed());
  const double cube = static_cast<double>(box.count()) * sizeof(Vec3f);
  const double places = lattice.faces.size();
  require_memory(fill_memory(box.size) + cube * (3 * s.colors + 3 * places), c.memory(), "the Wang cubes");
  const CubeSet set = make_cubes(read_solid(volume, box, "solid"), lattice, s, c.work().part(0, 0.95));
  const Torus<Vec3f> whole = assemble(set, lattice);
  c.metric("cubes_made", set.cube.size());
  c.metric("repetition", repetition(whole, lattice.cubes));
  Table table;
  table.columns = {"x", "y", "z", "cube"};
  const Torus<int> at(lattice.cubes, 0);
  for (std::size_t i = 0; i < at.at.size(); ++i) {
    const Vec3i p = at.place(i);
    table.rows.push_back({double(p.x()), double(p.y()), double(p.z()), double(set.at[i])});
  }
  Volume out;
  out.resolution = whole.size;
  add_vector_grid(out, "Cd", whole.size, box.spacing.x(), c.work().part(0.95, 1),
                  [&](std::size_t i) { return whole.at[i]; });
  c.output("table", std::move(table));
  c.output("volume", std::move(out));
}

}  // namespace

NodeType wang_cubes_node() {
  return NodeType("WangCubes", 1)
      .doc_(
          "Makes a large solid texture from a small one without repeating it. The cubes have colored faces, "
          "and two cubes match where their face colors agree.")
      .source_(
          "Lu, Ebert, Qiao, Kraus, Mora 2007, which Laursen, Ersbøll, Bærentzen 2011 propose in section 8; "
          "the "
          "cubes are filled with patches (Kopf et al. 2007) instead of cut from the solid")
      .input("solid", "Volume", "Solid texture with grid Cd that tiles, at least 16 voxels along each axis")
      .output("volume", "Volume", "Grid Cd: scene-linear color of all cubes side by side, periodic")
      .output("table", "Table", "Which cube is at each place of the lattice: x, y, z, cube")
      .parameter(Parameter::ints("cubes", {3})
                     .count(1, 3)
                     .range(1, 32)
                     .doc_("Number of cubes along each edge, or along x, y and z. A cube is as large as the "
                           "solid."))
      .parameter(Parameter::integer("colors", 2)
                     .range(1, 4)
                     .doc_("Number of colors of faces across each axis. At most colors⁶ different cubes are "
                           "made, 64 by default. 1 repeats the solid."))
      .parameter(Parameter::integer("rim", 2).range(1, 64).unit_("voxels").doc_(
          "Distance from a face within which cubes depend on its color only. Within this distance of two "
          "faces, all cubes equal the solid."))
      .parameter(Parameter::ints("iterations", {30, 8})
                     .count(1, 8)
                     .range(1, 1000)
                     .doc_("Iterations per level, coarsest first; the last number repeats"))
      .parameter(Parameter::seed())
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
