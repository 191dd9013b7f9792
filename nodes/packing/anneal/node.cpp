#include "graph/node_type.h"
#include "nodes/packing/rigid/figure.h"
#include "nodes/packing/rigid/packing.h"
#include "nodes/packing/rigid/request.h"
#include "nodes/packing/rigid/save_interrupted.h"
#include "nodes/packing/rigid/statistics.h"
#include "runtime/context.h"

namespace terrazzo::anneal {
namespace {

void compute(Context& c) {
  using namespace packing;
  const auto& distribution = c.input<SizeDistribution>("distribution");
  const auto& shapes = c.input<Shapes>("shapes");
  PackOptions o;
  o.population = read_population(c);
  o.population.binder_gap = c.number("binder_gap");
  o.population.all_void = c.keyword("voids") == "all";
  if (c.keyword("voids").empty()) o.population.void_classes = c.ints("voids");
  o.iterations = c.integer("iterations");
  o.on_jam = c.choice<OnJam>("on_jam");

  o.interrupted = saving(c, shapes);

  PackResult r = pack_particles(distribution, shapes, c.optional<Particles>("start"), o, c.work());
  for (const auto& note : r.notes) c.warn(note);
  report_population(c, r.particles, volume_fraction(shapes, r.particles), r.requested_fraction,
                    r.left_out_fraction, r.shrink < 1 || r.dropped > 0);
  c.metric("void_fraction", void_fraction(shapes, r.particles));
  c.metric("max_penetration", r.max_penetration);
  c.metric("box_x", r.particles.box[0]);
  c.metric("box_y", r.particles.box[1]);
  c.metric("box_z", r.particles.box[2]);
  c.metric("iterations", r.iterations);
  c.metric("steps", r.steps);
  if (r.reachable > 0) c.metric("reachable_fraction", r.reachable);
  c.metric("shrink", r.shrink);
  c.metric("dropped", r.dropped);
  c.metric("kept", r.kept);
  c.metric("coordination_number", *r.coordination);
  c.metric("nematic_order", nematic_order(shapes, r.particles));
  const Vec3 cut = sections_per_area(shapes, r.particles, c.work().quiet());
  c.metric("sections_per_area_x", cut[0]);
  c.metric("sections_per_area_y", cut[1]);
  c.metric("sections_per_area_z", cut[2]);
  c.metric("section_isotropy", cut.minCoeff() / cut.maxCoeff());
  Table sizes = size_table(distribution, r.expected, r.size_class, r.particles.box);
  Table correlation = pair_correlation(r.particles, 100, c.work().quiet());
  c.output("figure", figure_of(sizes, correlation, cut));
  c.output("sizes", std::move(sizes));
  c.output("correlation", std::move(correlation));
  c.output("particles", std::move(r.particles));
}

}  // namespace
}  // namespace terrazzo::anneal

namespace terrazzo {

NodeType anneal_node() {
  using namespace anneal;
  NodeType type("Anneal", 11);
  type.doc_(
          "Packs particles of given sizes and shapes into a periodic box without overlap. Particles grow at "
          "random positions while overlaps of their true surfaces are relaxed and jams are agitated. An "
          "independent, exact audit of the triangles verifies the result.")
      .source_("Jagnow, Dorsey, Rushmeier 2004, section 4.1")
      .input("distribution", "SizeDistribution", "Number density of particles by size class")
      .input("shapes", "Shapes", "Shapes referenced by the distribution, as closed meshes")
      .optional_input("start", {"Particles"},
                      "Initial packing; its particles are kept if their class has room. A packing that was "
                      "interrupted, or whose particles were shrunk, continues from its density.")
      .output("particles", "Particles", "The packing in the box [0, size)")
      .output("sizes", "Table", "Requested and achieved number of particles per size class")
      .output("correlation", "Table", "Pair correlation of the particle centers")
      .output("figure", "Image", "Plots of sizes, pair correlation, and sections per area along x, y and z");
  packing::declare_population(type);
  type.parameter(
          Parameter::choice("on_jam", "fail", {"fail", "shrink", "drop"})
              .doc_("What to do if the particles cannot be packed. fail: report an error. shrink: shrink all "
                    "particles by one factor until they fit. drop: leave out particles of all sizes until "
                    "the others fit. A trial of a sample estimates beforehand how dense they can be; shrink "
                    "and drop then pack slightly less."))
      .parameter(Parameter::number("binder_gap", 0)
                     .unit_("mm")
                     .range(0, 1e6)
                     .doc_("Smallest distance between particles"))
      .parameter(Parameter::with_keyword(ParameterKind::Ints, "voids", "none")
                     .keyword("all")
                     .range(0, 1e6)
                     .doc_("Classes of the distribution whose particles are holes, as in foams, sponges and "
                           "aerated concrete. Voids are packed like other particles."))
      .parameter(Parameter::integer("iterations", 6000)
                     .range(1, 1000000)
                     .doc_("Number of steps after which the particles are considered jammed. More steps "
                           "reach denser packings. A step is an iteration of all particles, or of some if "
                           "their shapes need many contact tests."))
      .compute_(compute);
  return type;
}

}  // namespace terrazzo
