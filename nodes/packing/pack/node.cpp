#include "graph/node_type.h"
#include "nodes/packing/cells/request.h"
#include "nodes/packing/deposit/deposit.h"
#include "nodes/packing/pack/choose.h"
#include "nodes/packing/rigid/figure.h"
#include "nodes/packing/rigid/request.h"
#include "nodes/packing/rigid/save_interrupted.h"
#include "nodes/packing/rigid/statistics.h"
#include "runtime/context.h"

namespace terrazzo::pack {
namespace {

// Volume fraction of the spheres that seed cells with joints. Circularity of cobbles fits best here: 0.55
// gives cells that are too regular, 0.15 some that are too flat.
constexpr double kStoneSeeds = 0.35;

void output_packed(Context& c, const SizeDistribution& distribution, const Shapes& shapes,
                   packing::PackResult r) {
  using namespace packing;
  for (const auto& note : r.notes) c.warn(note);
  std::vector<double> wanted;
  for (std::size_t i = 0; i < r.particles.count(); ++i)
    wanted.push_back(shapes.shapes[r.particles.shape[i]].volume *
                     std::pow(r.particles.scale[i] / r.shrink, 3));
  report_population(c, r.particles, volume_fraction(shapes, r.particles), r.requested_fraction,
                    r.left_out_fraction, r.shrink < 1 || r.dropped > 0);
  c.metric("box_x", r.particles.box[0]);
  c.metric("box_y", r.particles.box[1]);
  c.metric("box_z", r.particles.box[2]);
  if (r.coordination) c.metric("coordination_number", *r.coordination);
  c.metric("shrink", r.shrink);
  c.metric("dropped", r.dropped);
  c.output("table", tessellation::particle_table(shapes, r.particles, wanted));
  c.output("figure", figure_of(size_table(distribution, r.expected, r.size_class, r.particles.box),
                               pair_correlation(r.particles, 100, c.work().quiet()),
                               sections_per_area(shapes, r.particles, c.work().quiet())));
  c.output("particles", std::move(r.particles));
  c.output("shapes", shapes);
}

packing::PackResult deposit(Context& c, const SizeDistribution& distribution, const Shapes& shapes) {
  packing::PopulationOptions o = packing::read_population(c);
  if (const Profiles* profiles = c.optional<Profiles>("profiles")) o = bed_like(distribution, *profiles, o);
  return packing::deposit_particles(distribution, shapes, o, c.work());
}

packing::PackResult anneal(Context& c, const SizeDistribution& distribution, const Shapes& shapes) {
  packing::PackOptions o;
  o.population = packing::read_population(c);
  o.population.binder_gap = c.optional_number("gap").value_or(0);
  o.on_jam = c.choice<packing::OnJam>("on_jam");
  o.interrupted = packing::saving(c, shapes);
  return packing::pack_particles(distribution, shapes, c.optional<Particles>("start"), o, c.work());
}

void compute(Context& c) {
  using namespace tessellation;
  const auto& distribution = c.input<SizeDistribution>("distribution");
  const auto& shapes = c.input<Shapes>("shapes");
  Method method = c.choice<Method>("method");
  Work work = c.work();
  Choice choice;
  if (method == Method::Auto) {
    packing::PackOptions options;
    options.population = packing::read_population(c);
    options.population.binder_gap = c.optional_number("gap").value_or(0);
    options.interrupted = packing::saving(c, shapes);
    choice = choose_method(distribution, shapes, c.optional<Profiles>("profiles"),
                           c.optional<Particles>("start"), options, work.part(0, 0.5));
    work = work.part(0.5, 1);
    const Profiles* profiles = c.optional<Profiles>("profiles");
    const bool surface = profiles && profiles->view == View::Surface;
    if (choice.method != Method::Anneal || surface) c.warn(choice.reason);
  }
  const bool chosen = method == Method::Auto;
  if (chosen) method = choice.method;
  for (const auto& [word, value] : {std::pair{"by_anneal", Method::Anneal},
                                    {"by_grow", Method::Grow},
                                    {"by_laguerre", Method::Laguerre},
                                    {"by_deposit", Method::Deposit}})
    c.metric(word, method == value);
  if (c.has("start") && method != Method::Anneal)
    c.warn("`start` has no effect: only method anneal continues from it");
  if (method == Method::Anneal || method == Method::Deposit) {
    if (!chosen)
      choice.packed =
          method == Method::Anneal ? anneal(c, distribution, shapes) : deposit(c, distribution, shapes);
    output_packed(c, distribution, shapes, std::move(choice.packed));
    return;
  }
  const auto fill = method == Method::Grow ? tessellation::Method::Grow : tessellation::Method::Laguerre;
  FillOptions options = read_fill(c, fill);
  if (choice.joints) {  // stones are irregular
    options.grains.seed_fraction = kStoneSeeds;
    if (!c.optional_integer("rounds")) options.grains.rounds = 0;
  }
  output_fill(c, distribution, fill_space(distribution, shapes, options, work));
}

}  // namespace
}  // namespace terrazzo::pack

namespace terrazzo {

NodeType pack_node() {
  using namespace pack;
  NodeType type("Pack", 16);
  type.doc_(
          "Packs particles of any density into a periodic box: rigid particles where they fit (as Anneal), "
          "particles grown into each other where they do not, and a tessellation where there is no binder "
          "(both as Tessellate).")
      .source_("Jagnow, Dorsey, Rushmeier 2004, section 4.1; see Tessellate")
      .input("distribution", "SizeDistribution", "Number density of particles by size class")
      .input("shapes", "Shapes", "Shapes referenced by the distribution, as closed meshes")
      .optional_input(
          "profiles", {"Profiles"},
          "Profiles of the photograph: the thickness of the binder between neighbors, and whether "
          "it shows a surface")
      .optional_input("start", {"Particles"},
                      "anneal: initial packing, for example of an interrupted run, see Anneal")
      .output("particles", "Particles", "The particles in the box [0, size)")
      .output("shapes", "Shapes", "The shapes of the input, or one shape per particle")
      .output("table", "Table", "Class, volumes, size, surface and sphericity of each particle")
      .output("figure", "Image",
              "Histograms of size and, by method, pair correlation and sections per area, or sphericity and "
              "volume error")
      .parameter(
          Parameter::choice("method", "auto", {"auto", "anneal", "grow", "laguerre", "deposit"})
              .doc_("auto: deposit if the input `profiles` shows loose stones; anneal, with the flat side "
                    "down, "
                    "if it shows stones in soil. Else "
                    "laguerre if at least 0.97 of the volume is particles, or 0.75 and the profiles are "
                    "equiaxed; else anneal, or grow if rigid particles jam below the photograph's "
                    "fraction by more than its standard error. anneal: "
                    "rigid particles. grow: particles with flat contacts. "
                    "laguerre: convex cells of given volumes. deposit: stones that fell onto the bottom of "
                    "the box "
                    "and lie on each other, as dense as they come to rest; air above them."))
      .parameter(Parameter::choice("on_jam", "shrink", {"fail", "shrink", "drop"})
                     .doc_("anneal: what to do if the particles cannot be packed, see Anneal"));
  packing::declare_population(type);
  tessellation::declare_fill(type);
  type.check_(tessellation::check_fill).compute_(compute);
  return type;
}

}  // namespace terrazzo
