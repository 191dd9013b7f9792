#include <fmt/format.h>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/geometry/one_or_three.h"
#include "nodes/cooccurrence/cooccurrence_solid/cooccurrence_solid.h"
#include "nodes/data/table.h"
#include "runtime/context.h"

namespace terrazzo::cooccurrence_solid {
namespace {

void check(const NodeParameters& p) {
  const Vec3i size = one_or_three(p, "size");
  if (size.cast<double>().prod() > 1 << 30)
    throw Error("too-large", fmt::format("{} × {} × {} voxels are too many", size.x(), size.y(), size.z()),
                "make the solid smaller: it tiles")
        .parameter("size");
}

void compute(Context& c) {
  const Image& image = c.input<Image>("image");
  std::array<const Image*, 3> pictures = {&image, &image, &image};
  if (const auto* y = c.optional<Image>("image_y")) pictures[1] = y;
  if (const auto* z = c.optional<Image>("image_z")) pictures[2] = z;
  SolidFieldOptions s;
  s.levels = c.integer("levels");
  s.extent = c.integer("extent");
  s.scales = c.integer("scales");
  s.sweeps = c.integer("sweeps");
  s.space = c.choice<ColorSpace>("space");
  s.start = c.choice<Start>("start");
  s.seed = c.seed();
  s.size = one_or_three(c, "size");
  const SolidFieldResult r = synthesize_solid(pictures, s, c.work().part(0, 0.95));

  c.metric("error_start", r.noise_error);
  c.metric("error", r.sweeps.back().error);
  const char* names[] = {"error_x", "error_y", "error_z"};
  for (std::size_t a = 0; a < 3; ++a) c.metric(names[a], r.axis_error[a]);
  Volume volume;
  volume.resolution = s.size;
  add_vector_grid(volume, "Cd", s.size, image.pixel_size, c.work().part(0.95, 1),
                  [&](std::size_t i) { return r.levels.color[r.field.at[i]]; });
  c.output("table", descent_table(r.sweeps));
  c.output("volume", std::move(volume));
}

}  // namespace
}  // namespace terrazzo::cooccurrence_solid

namespace terrazzo {

NodeType cooccurrence_solid_node() {
  using namespace cooccurrence_solid;
  return NodeType("CooccurrenceSolid", 2)
      .doc_(
          "Makes a tileable solid texture from noise. On its slices across x, y and z, colors are neighbors "
          "as often as in the pictures.")
      .source_("Malzbender and Spach 1993, section 3, applied to slices across three axes")
      .input("image", "Image",
             "Picture for slices across x, and for slices across y and z that have no picture of their own. "
             "On x and y a picture's columns run along y and x and its rows upwards along z; on z they run "
             "along x and y.")
      .optional_input("image_y", {"Image"}, "Picture for slices across y")
      .optional_input("image_z", {"Image"}, "Picture for slices across z")
      .output("volume", "Volume", "Grid Cd: scene-linear color, one voxel per pixel, periodic")
      .output("table", "Table",
              "Sweeps at each resolution (one in `stride` voxels): sweep, error E of the three matrices, "
              "voxels changed. Sweep 0 is the start.")
      .parameter(Parameter::integer("levels", 8)
                     .range(2, kMostLevels)
                     .doc_("Number of colors, found by k-means on all pictures"))
      .parameter(Parameter::choice("space", "oklab", {"oklab", "rgb"})
                     .doc_("Color space for clustering: Oklab, or display-encoded RGB"))
      .parameter(Parameter::integer("extent", 2)
                     .range(1, 8)
                     .unit_("pixels")
                     .doc_("Largest offset, in both directions within the plane of a slice"))
      .parameter(Parameter::integer("scales", 1)
                     .range(1, 6)
                     .doc_("Number of scales. Offsets are also used 2, 4, … times as long, up to 2^(scales − "
                           "1), to capture longer correlations."))
      .parameter(Parameter::choice("start", "coarse", {"coarse", "noise"})
                     .doc_("coarse: starts at a fraction of the resolution and refines, so that long "
                           "structures find their places. noise: full resolution only."))
      .parameter(Parameter::integer("sweeps", 8)
                     .range(1, 1000)
                     .doc_("Most sweeps over all voxels at each resolution"))
      .parameter(Parameter::ints("size", {64})
                     .count(1, 3)
                     .range(4, 1024)
                     .unit_("voxels")
                     .doc_("Edge length, or one length per axis"))
      .parameter(Parameter::seed())
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
