#include <fmt/format.h>

#include <cmath>

#include "graph/node_type.h"
#include "nodes/voxelize/voxelize.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  const auto& particles = c.input<Particles>("particles");
  const Lattice lattice = choose_lattice(particles.box, c.ints("resolution"));
  VoxelReport report;
  Volume volume = voxelize(particles, c.input<Shapes>("shapes"), c.optional<Volume>("residual"), lattice,
                           report, c.work());
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
        "{} of {} particles hold no voxel's centre and are absent from the grid id: voxels of {:.3g} mm",
        report.without_voxel, particles.count(), lattice.voxel));
  if (report.detail_periods.minCoeff() > 0) {
    const double scale = std::exp(report.detail_scale.array().log().abs().maxCoeff());
    c.metric("residual_scale", scale);
    const Vec3 fitting = report.detail_scale.cwiseProduct(report.detail_periods.cast<double>())
                             .cwiseProduct(c.optional<Volume>("residual")->resolution.cast<double>());
    if (scale > 1.25)
      c.warn(fmt::format(
          "the residual is scaled by {:.2f} × {:.2f} × {:.2f} to tile the box; one of {:.0f} × {:.0f} × "
          "{:.0f} voxels, or a half or a third of that, keeps its scale",
          report.detail_scale.x(), report.detail_scale.y(), report.detail_scale.z(), fitting.x(), fitting.y(),
          fitting.z()));
  }
  c.output("volume", std::move(volume));
}

}  // namespace

NodeType voxelize_node() {
  return NodeType("Voxelize", 4)
      .doc_("Particles, binder and fine detail as OpenVDB grids that tile: density, surface, Cd and id.")
      .input("particles", "Particles", "in their periodic box")
      .input("shapes", "Shapes", "the particles' meshes")
      .optional_input("residual", {"Volume"},
                      "grid residual of ResidualSynth: offsets of sRGB-encoded colours, added everywhere")
      .output("volume", "Volume",
              "density (1 inside, antialiased), surface (level set, mm), Cd (scene-linear colour), id (index "
              "of the "
              "particle, −1 in the binder), and where there are voids void (1 inside them, antialiased)")
      .parameter(Parameter::ints("resolution", {128})
                     .count(1, 3)
                     .range(4, 4096)
                     .unit_("voxels")
                     .doc_("Along the box's longest edge, or along x, y and z. Voxels are cubes: every edge "
                           "must be a whole "
                           "number of them"))
      .compute_(compute);
}

}  // namespace terrazzo
