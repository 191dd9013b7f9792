#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "graph/node_type.h"
#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/solids/morph_solids/morph_solids.h"
#include "nodes/solids/patch_fill/read_solid.h"
#include "runtime/context.h"
#include "runtime/memory.h"

namespace terrazzo {
namespace {

using namespace morph_solids;
using namespace patch_fill;

std::string text_of(const Vec3i& n) { return fmt::format("{} × {} × {}", n.x(), n.y(), n.z()); }

// The field of weights that the parameters describe.
Torus<float> weight_of(const Context& c, const Vec3i& size) {
  const float most = c.number("weight");
  Torus<float> out(size, most);
  const int axis = c.choice<int>("along") - 1;
  if (axis < 0) return out;
  for (std::size_t i = 0; i < out.at.size(); ++i) {
    const double at = (out.place(i)[axis] + 0.5) / size[axis];
    const double inside = std::min(at, 1 - at);  // distance from the ends, 0 to 0.5 edges
    out.at[i] *= static_cast<float>(std::clamp(0.5 + (inside - 0.25) / c.number("ramp"), 0.0, 1.0));
  }
  return out;
}

Torus<float> weight_of(const Volume& volume, const std::string& name, const VoxelBox& solid) {
  const VoxelBox box = voxel_box(volume);
  if (box.size != solid.size)
    throw Error(
        "size-mismatch",
        fmt::format("the weights have {} voxels, the solids {}", text_of(box.size), text_of(solid.size)),
        "connect weights of the same size");
  const std::vector<std::string> names = grid_names(volume);
  if (name.empty() && names.size() != 1)
    throw Error("several-grids", fmt::format("the volume of weights has {} grids", names.size()),
                "set grid to the one to use")
        .parameter("grid");
  const VoxelSource source(volume, name.empty() ? names[0] : name, box);
  if (source.components() != 1 || source.whole())
    throw Error("not-a-scalar",
                fmt::format("grid '{}' does not hold one real number per voxel", source.name()),
                "connect a grid of floats from 0 to 1");
  Torus<float> out(box.size, 0);
  source.read(0, box.size.z(), out.at.data());
  const auto [least, most] = std::minmax_element(out.at.begin(), out.at.end());
  if (*least < 0 || *most > 1)
    throw Error("bad-values",
                fmt::format("the weights in grid '{}' go from {} to {}", source.name(), *least, *most),
                "connect weights from 0 to 1");
  return out;
}

void compute(Context& c) {
  const Volume &a = c.input<Volume>("a"), &b = c.input<Volume>("b");
  const VoxelBox box = solid_box(a, "a"), other = solid_box(b, "b");
  if (box.size != other.size)
    throw Error("size-mismatch",
                fmt::format("solid a has {} voxels, solid b {}", text_of(box.size), text_of(other.size)),
                "make both of one size");
  if (((box.spacing - other.spacing).array().abs() > 1e-6 * box.spacing.array()).any())
    throw Error("size-mismatch",
                fmt::format("a voxel of solid a is {:.6g} mm wide, one of solid b {:.6g} mm", box.spacing.x(),
                            other.spacing.x()),
                "make both with one pixel size");
  require_memory(fill_memory(box.size), c.memory(), "the solid between");
  const Volume* weights = c.optional<Volume>("weights");
  const Torus<float> weight = weights ? weight_of(*weights, c.text("grid"), box) : weight_of(c, box.size);
  FillOptions s;
  s.iterations.clear();
  for (const auto n : c.ints("iterations")) s.iterations.push_back(static_cast<int>(n));
  s.exponent = c.number("exponent");
  s.window = c.number("window");
  s.overuse = c.number("overuse");
  s.seed = c.seed();
  const FillResult r =
      morph(read_solid(a, box, "a"), read_solid(b, box, "b"), weight, s, c.work().part(0, 0.97));
  c.metric("levels", r.levels);
  c.metric("synthesized", static_cast<double>(r.filled) / weight.at.size());
  Volume volume;
  volume.resolution = box.size;
  add_vector_grid(volume, "Cd", box.size, box.spacing.x(), c.work().part(0.97, 1),
                  [&](std::size_t i) { return r.color.at[i]; });
  c.output("volume", std::move(volume));
}

}  // namespace

NodeType morph_solids_node() {
  return NodeType("MorphSolids", 1)
      .doc_(
          "Synthesizes a solid texture between two, for a transition between materials. Structures and "
          "colors morph from one to the other instead of cross-fading.")
      .source_(
          "Laursen, Ersbøll, Bærentzen 2011, section 8, which proposes it; patches of two textures with "
          "interpolated histograms after Ruiters, Schnabel, Klein 2010; Kopf et al. 2007")
      .input("a", "Volume", "Solid texture with grid Cd that tiles, at least 16 voxels along each axis")
      .input("b", "Volume", "Solid texture of the same size and voxel size")
      .optional_input("weights", {"Volume"},
                      "Weight of b at each voxel, 0 to 1, as a grid of floats of the same size. Without it, "
                      "the parameters weight, along and ramp apply.")
      .output(
          "volume", "Volume",
          "Grid Cd: scene-linear color, periodic. Voxels of weight 0 are those of a and voxels of weight 1 "
          "those of b, bit for bit.")
      .parameter(Parameter::number("weight", 0.5)
                     .range(0, 1)
                     .doc_("Weight of b: everywhere, or in the middle of the solid if along is an axis. Not "
                           "used with input weights."))
      .parameter(
          Parameter::choice("along", "none", {"none", "x", "y", "z"})
              .doc_("Axis along which the weight rises from 0 at both ends of the solid to its full "
                    "value in the middle. none: the weight is the same everywhere. Not used with input "
                    "weights."))
      .parameter(
          Parameter::number("ramp", 0.25)
              .range(0.01, 0.5)
              .doc_("Length of each of the two ramps along the axis, as a fraction of the solid's edge. "
                    "Their middles are at a quarter and three quarters of the edge."))
      .parameter(Parameter::text("grid", "").doc_("Grid of the weights. Empty: the only one."))
      .parameter(Parameter::ints("iterations", {30, 8})
                     .count(1, 8)
                     .range(1, 1000)
                     .doc_("Iterations per level, coarsest first; the last number repeats"))
      .parameter(Parameter::number("exponent", 0.8)
                     .range(0.1, 2)
                     .doc_("Exponent r of patch distances. Smaller values are more robust to outliers."))
      .parameter(Parameter::number("window", 0.02)
                     .range(0.001, 10)
                     .doc_("Width of the mean shift at the end of each level, in standard deviations of the "
                           "colors. It starts ten times as wide. Wide windows blur."))
      .parameter(
          Parameter::number("overuse", 1)
              .range(0, 100)
              .doc_("Penalty on patches that are used more often than average. With 0, motifs repeat."))
      .parameter(Parameter::seed())
      .compute_(compute);
}

}  // namespace terrazzo
