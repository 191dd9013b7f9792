#include <fmt/format.h>

#include <cmath>

#include "graph/node_type.h"
#include "nodes/volumes/voxelize/voxelize.h"
#include "runtime/context.h"

namespace terrazzo::voxelize {
namespace {

void compute(Context& c) {
  const auto& particles = c.input<Particles>("particles");
  const Lattice lattice = choose_lattice(particles.box, c.ints("resolution"));
  VoxelReport report;
  Volume volume =
      voxelize::voxelize(particles, c.input<Shapes>("shapes"), c.optional<Volume>("detail"), lattice, report,
                         c.work(), c.optional<Detail>("detail"), c.intermediates());
  c.metric("volume_fraction", report.volume_fraction);
  c.metric("exact_volume_fraction", report.exact_volume_fraction);
  if (c.input<Particles>("particles").void_count() > 0) {
    c.metric("void_fraction", report.void_fraction);
    c.metric("exact_void_fraction", report.exact_void_fraction);
  }
  c.metric("overlap_fraction", report.overlap_fraction);
  c.metric("voxel_size", lattice.voxel);
  if (report.without_voxel > 0)
    c.warn(fmt::format(
        "{} of {} particles contain no voxel center and are missing from the grid id; a voxel is {:.3g} mm",
        report.without_voxel, particles.count(), lattice.voxel));
  if (report.detail_periods.minCoeff() > 0) {
    const double scale = std::exp(report.detail_scale.array().log().abs().maxCoeff());
    c.metric("residual_scale", scale);
    const Vec3 fitting = report.detail_scale.cwiseProduct(report.detail_periods.cast<double>())
                             .cwiseProduct(c.optional<Volume>("detail")->resolution.cast<double>());
    if (scale > 1.25)
      c.warn(
          fmt::format("the residual is scaled by {:.2f} × {:.2f} × {:.2f} to tile the box; a residual of "
                      "{:.0f} × {:.0f} × {:.0f} voxels, or half or a third of that, would keep its scale",
                      report.detail_scale.x(), report.detail_scale.y(), report.detail_scale.z(), fitting.x(),
                      fitting.y(), fitting.z()));
  }
  c.output("volume", std::move(volume));
}

}  // namespace
}  // namespace terrazzo::voxelize

namespace terrazzo {

NodeType voxelize_node() {
  using namespace voxelize;
  return NodeType("Voxelize", 7)
      .doc_(
          "Converts particles, binder and fine detail to tileable OpenVDB grids: density, surface, Cd and "
          "id.")
      .input("particles", "Particles", "Particles in a periodic box")
      .input("shapes", "Shapes", "Shapes of the particles")
      .optional_input(
          "detail", {"Detail", "Volume"},
          "Fine detail from DetailSolid, or a volume with the grid residual from ResidualSynth: offsets of "
          "sRGB-encoded colors")
      .input_was("residual")
      .output("volume", "Volume",
              "Grids density (1 inside, antialiased), surface (level set, mm), Cd (scene-linear color), id "
              "(index of the particle, −1 in the binder) and, if there are voids, void (1 inside, "
              "antialiased)")
      .parameter(
          Parameter::ints("resolution", {128})
              .count(1, 3)
              .range(4, 4096)
              .unit_("voxels")
              .doc_("Voxels along the box's longest edge, or along x, y and z. Voxels are cubes, so every "
                    "edge must be a whole number of voxels."))
      .compute_(compute);
}

}  // namespace terrazzo
