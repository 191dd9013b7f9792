#include "nodes/packing/cells/request.h"

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/io/particles_json.h"
#include "nodes/packing/cells/corner_roundness.h"
#include "nodes/packing/cells/joints.h"
#include "nodes/packing/rigid/request.h"
#include "nodes/packing/rigid/statistics.h"

namespace terrazzo::tessellation {
namespace {

// Joints keep about half of the binder, and the corners that edges leave get the other half.
constexpr double kLeastGap = 0.45;

}  // namespace

NodeType& declare_fill(NodeType& type) {
  return type
      .parameter(
          Parameter::optional_number("gap", "auto")
              .unit_("mm")
              .range(0, 1e6)
              .doc_("Thickness of the binder between neighbors. auto: laguerre chooses it to meet the "
                    "volume fraction; grow takes the median that the input `profiles` shows, or 0 without "
                    "that input."))
      .parameter(
          Parameter::optional_number("gap_variation", "auto")
              .range(0, 1)
              .doc_("How much the gap varies from face to face, relative to its mean. auto: as much as "
                    "the input `profiles` shows, or 0 without that input."))
      .parameter(
          Parameter::optional_number("roundness", "auto")
              .range(0, 1)
              .doc_("How round edges are. 0 is sharp. auto: as round as the corners of the input `profiles`, "
                    "as far as the volume fraction leaves room, or sharp without that input."))
      .parameter(Parameter::number("roughness", 0)
                     .range(0, 0.1)
                     .doc_("laguerre: root mean square displacement of faces, in mean grain diameters. Both "
                           "sides of a face share it, so that neighbors fit each other."))
      .parameter(
          Parameter::optional_integer("rounds", "auto")
              .range(0, 1000)
              .doc_("laguerre: how often each seed moves to the centroid of its cell. More rounds make "
                    "rounder and more regular grains. auto: 5, or 0 where Pack chose cells for the stones "
                    "of a photograph."))
      .parameter(Parameter::numbers("stretch", {1})
                     .range(0.05, 20)
                     .count(1, 3)
                     .doc_("laguerre: proportions of grains along x, y and z, as in rolled metal. One value: "
                           "equiaxed grains."))
      .parameter(
          Parameter::integer("corrections", 2)
              .range(0, 50)
              .doc_("How often the sizes are corrected after comparing sections of the result with the "
                    "profiles that the distribution stands for"))
      .parameter(Parameter::choice("crystal_axes", "none", {"none", "uniform", "fiber"})
                     .doc_("Orientation of each grain's crystal, stored as the particle's orientation. none: "
                           "that of packing, if any. uniform: random. fiber: crystal z near the box's z."))
      .parameter(Parameter::number("fiber_spread", 10)
                     .range(0, 90)
                     .unit_("degrees")
                     .doc_("Standard deviation of the tilt of a fiber's axes"));
}

void check_fill(const NodeParameters& p) {
  if (p.numbers("stretch").size() == 2)
    throw Error("bad-stretch", "stretch has two values", "give one value or three: x, y and z")
        .parameter("stretch");
}

FillOptions read_fill(Context& c, Method method) {
  FillOptions o;
  o.method = method;
  o.population = packing::read_population(c);
  if (method == Method::Grow) o.population.most = kMostGrown;
  o.grains.gap = c.optional_number("gap");
  Joints joints;
  const auto* profiles = c.optional<Profiles>("profiles");
  if (profiles != nullptr) joints = measure_joints(*profiles, c.work().quiet());
  if (method == Method::Grow && !o.grains.gap) o.grains.gap = joints.thickness;
  o.grains.gap_variation = c.optional_number("gap_variation").value_or(joints.variation);
  if (const auto roundness = c.optional_number("roundness"))
    o.grains.roundness = *roundness;
  else if (profiles != nullptr) {
    o.grains.roundness = measure_roundness(*profiles);
    o.grains.least_gap = kLeastGap;
  }
  o.grains.roughness = c.number("roughness");
  if (const auto rounds = c.optional_integer("rounds")) o.grains.rounds = static_cast<int>(*rounds);
  if (const auto s = c.numbers("stretch"); s.size() == 3) o.grains.stretch = Vec3(s[0], s[1], s[2]);
  o.grains.seed = c.seed();
  o.corrections = static_cast<int>(c.integer("corrections"));
  o.axes = c.choice<CrystalAxes>("crystal_axes");
  o.spread = c.number("fiber_spread");
  o.interrupted = [&c](const Particles& particles, const Shapes& shapes, bool grown) {
    const double fraction = packing::volume_fraction(shapes, particles);
    c.save_interrupted(
        ".json",
        fmt::format("the {} so far ({} particles, volume fraction {:.3f})", grown ? "result" : "packing",
                    particles.count(), fraction),
        "to use it, load it with LoadParticles and LoadShapes",
        [&](const std::filesystem::path& file) { write_packing_json(file, particles, shapes); });
  };
  return o;
}

void output_fill(Context& c, const SizeDistribution& distribution, FillResult r) {
  for (const auto& note : r.notes) c.warn(note);
  packing::report_population(c, r.particles, r.fraction, r.requested_fraction, r.left_out_fraction,
                             /*explained=*/false);
  if (r.worst > 0.05)
    c.warn(fmt::format("the volume of one particle is off by {:.0f} %: its neighbors leave it no room",
                       100 * r.worst));
  c.metric("worst_volume_error", r.worst);
  c.metric("mean_volume_error", r.mean_error);
  c.metric("effort", r.effort);
  c.metric("box_x", r.particles.box[0]);
  c.metric("box_y", r.particles.box[1]);
  c.metric("box_z", r.particles.box[2]);
  c.metric("gap", r.gap);
  c.metric("faces", r.faces);
  c.metric("flat_contact", r.flat);
  c.metric("roundness", r.roundness);
  c.metric("core_fraction", r.packed_fraction);
  c.metric("section_misfit_before", r.misfit_before);
  c.metric("section_misfit", r.misfit_after);
  c.metric("section_misfit_by_chance", r.misfit_by_chance);
  c.output("table", particle_table(r.shapes, r.particles, r.wanted));
  c.output("figure", fill_figure(distribution, r));
  c.output("particles", std::move(r.particles));
  c.output("shapes", std::move(r.shapes));
}

}  // namespace terrazzo::tessellation
