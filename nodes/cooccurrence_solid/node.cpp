#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/common/dense_grid.h"
#include "nodes/common/one_or_three.h"
#include "nodes/cooccurrence_solid/cooccurrence_solid.h"
#include "nodes/data/table.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

using namespace cooccurrence_solid;

void compute(Context& c) {
  const Image& image = c.input<Image>("image");
  std::array<const Image*, 3> pictures = {&image, &image, &image};
  if (const auto* y = c.optional<Image>("image_y")) pictures[1] = y;
  if (const auto* z = c.optional<Image>("image_z")) pictures[2] = z;
  SolidFieldSettings s;
  s.levels = static_cast<int>(c.integer("levels")), s.extent = static_cast<int>(c.integer("extent"));
  s.scales = static_cast<int>(c.integer("scales")), s.sweeps = static_cast<int>(c.integer("sweeps"));
  s.space = c.text("space"), s.from_noise = c.text("start") == "noise",
  s.seed = static_cast<std::uint64_t>(c.integer("seed"));
  s.size = one_or_three(c, "size");
  const double voxels = s.size.cast<double>().prod();
  if (voxels > 1 << 30)
    throw Error("too-large", fmt::format("{} × {} × {} voxels", s.size.x(), s.size.y(), s.size.z()),
                "make the solid smaller: it tiles")
        .parameter("size");
  const SolidFieldResult r = synthesize_solid(pictures, s, c.work().part(0, 0.95));

  c.metric("error_start", r.noise_error);
  c.metric("error", r.sweeps.back().error);
  const char* names[] = {"error_x", "error_y", "error_z"};
  for (std::size_t a = 0; a < 3; ++a) c.metric(names[a], r.axis_error[a]);
  initialize_openvdb();
  Volume volume;
  volume.resolution = s.size;
  volume.grids.push_back(dense_grid<openvdb::Vec3SGrid>("Cd", s.size, image.pixel_size,
                                                        c.work().part(0.95, 1), [&](std::size_t i) {
                                                          const Vec3f& v = r.levels.color[r.field.at[i]];
                                                          return openvdb::Vec3s(v.x(), v.y(), v.z());
                                                        }));
  c.output("table", descent_table(r.sweeps));
  c.output("volume", std::move(volume));
}

}  // namespace

NodeType cooccurrence_solid_node() {
  return NodeType("CooccurrenceSolid", 2)
      .doc_(
          "Makes a tileable solid texture from noise: on its slices across x, y and z colours neighbour each "
          "other as "
          "often as in the pictures")
      .source_("Malzbender and Spach 1993, section 3, on the slices of three axes")
      .input("image", "Image",
             "what slices look like: those across x, and those across y and z where these have no picture of "
             "their own. On x "
             "and y a picture's columns run along y and x, its rows upwards along z; on z along x and y")
      .optional_input("image_y", {"Image"}, "what slices across y look like")
      .optional_input("image_z", {"Image"}, "what slices across z look like")
      .output("volume", "Volume", "grid Cd, scene-linear, one voxel a pixel, periodic")
      .output("table", "Table",
              "of each resolution, one of `stride` voxels: sweep, error E of the three matrices, voxels "
              "changed; sweep 0 is "
              "its start")
      .parameter(Parameter::integer("levels", 8)
                     .range(2, kMostLevels)
                     .doc_("Colours, found by k-means on all pictures"))
      .parameter(Parameter::choice("space", "oklab", {"oklab", "rgb"})
                     .doc_("Where colours are clustered: Oklab, or RGB as displays show it"))
      .parameter(Parameter::integer("extent", 2)
                     .range(1, 8)
                     .unit_("pixels")
                     .doc_("Offsets go up to ± this in the plane of a slice"))
      .parameter(Parameter::integer("scales", 1)
                     .range(1, 6)
                     .doc_("The offsets are also taken 2, 4, … times as long, up to 2^(scales − 1), for "
                           "longer correlations"))
      .parameter(
          Parameter::choice("start", "coarse", {"coarse", "noise"})
              .doc_(
                  "coarse: made at half, a quarter, … of the resolution first, so that long structures find "
                  "their places. noise: at full resolution alone"))
      .parameter(Parameter::integer("sweeps", 8)
                     .range(1, 1000)
                     .doc_("Visits of every voxel at each resolution, at most"))
      .parameter(Parameter::ints("size", {64})
                     .count(1, 3)
                     .range(4, 1024)
                     .unit_("voxels")
                     .doc_("Edge, or one for each axis"))
      .parameter(Parameter::integer("seed", 1)
                     .range(0, 9007199254740991)
                     .doc_("Of the noise and the order of visits"))
      .compute_(compute);
}

}  // namespace terrazzo
