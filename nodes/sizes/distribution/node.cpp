#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/sizes/distribution/size_laws.h"
#include "runtime/context.h"

namespace terrazzo::distribution {
namespace {

SizeLaw law_of(const NodeParameters& c) {
  SizeLaw law;
  law.kind = c.choice<LawKind>("kind");
  law.mean = c.number("mean");
  law.sd = c.number("sd");
  law.exponent = c.number("exponent");
  law.min = c.number("min");
  if (const auto v = c.optional_number("max")) law.max = *v;
  law.density_by = c.choice<DensityBy>("density_by");
  law.volume = c.number("volume");
  law.classes = c.integer("classes");
  if (c.keyword("class_edges").empty()) law.class_edges = c.numbers("class_edges");
  if (c.keyword("N_V").empty()) law.N_V = c.numbers("N_V");
  if (c.keyword("low").empty()) law.low = c.numbers("low");
  if (c.keyword("high").empty()) law.high = c.numbers("high");
  if (const auto v = c.optional_number("volume_fraction")) law.volume_fraction = *v;
  if (const auto v = c.optional_number("number_density")) law.number_density = *v;
  law.types = c.choice<Types>("types");
  return law;
}

void check(const NodeParameters& p) { check_law(law_of(p)); }

void compute(Context& c) {
  SizeDistribution d = make_distribution(law_of(c), c.optional<Shapes>("shapes"));
  double number = 0;
  for (const auto& e : d.shapes)
    for (const double v : e.N_V) number += v;
  c.metric("volume_fraction", d.volume_fraction);
  c.metric("number_density", number);
  c.metric("d_max", d.d_max);
  c.output("distribution", std::move(d));
}

}  // namespace
}  // namespace terrazzo::distribution

namespace terrazzo {

NodeType distribution_node() {
  using namespace distribution;
  return NodeType("Distribution", 1)
      .doc_(
          "Defines a particle size distribution by hand: by class, or as a law by number or by volume. The "
          "size of a particle is √(4·A_max/π), with A_max the area of its largest section; for a sphere it "
          "is the diameter.")
      .optional_input("shapes", {"Shapes"},
                      "Shapes that determine the volume of a particle; without them, particles are spheres")
      .output("distribution", "SizeDistribution", "Particles per mm³ by size class, for any shape")
      .parameter(
          Parameter::choice("kind", "lognormal",
                            {"classes", "lognormal", "normal", "uniform", "rosin_rammler", "equal_volume"})
              .doc_("classes: uses class_edges and N_V. lognormal, normal: use mean and sd. uniform: "
                    "uses min and max. rosin_rammler: uses mean (63.2 % are smaller) and exponent. "
                    "equal_volume: all particles have `volume`, whatever their shapes."))
      .parameter(Parameter::number("mean", 5).unit_("mm").range(1e-9, 1e9).doc_("Mean size"))
      .parameter(
          Parameter::number("sd", 1.5).unit_("mm").range(1e-9, 1e9).doc_("Standard deviation of the sizes"))
      .parameter(Parameter::number("exponent", 3)
                     .range(0.1, 100)
                     .doc_("Exponent of rosin_rammler. Larger values make the distribution narrower."))
      .parameter(Parameter::number("min", 0).unit_("mm").range(0, 1e9).doc_(
          "Smallest size; the law is cut off below it"))
      .parameter(Parameter::optional_number("max", "auto")
                     .unit_("mm")
                     .range(1e-9, 1e9)
                     .doc_("Largest size; the law is cut off above it. auto: the size that 0.1 % exceed."))
      .parameter(Parameter::number("volume", 1)
                     .unit_("mm³")
                     .range(1e-27, 1e27)
                     .doc_("Volume of every particle, for kind: equal_volume"))
      .parameter(Parameter::choice("density_by", "number", {"number", "volume"})
                     .doc_("Quantity that the law distributes. number: the share of particles of each size. "
                           "volume: the share of particle volume of each size."))
      .parameter(Parameter::integer("classes", 10)
                     .range(1, 1000)
                     .doc_("Number of equal classes that a law is divided into"))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "class_edges", "none")
                     .unit_("mm")
                     .range(0, 1e9)
                     .count(2, 1001)
                     .doc_("Class edges for kind: classes: n + 1 increasing sizes"))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "N_V", "none")
                     .unit_("mm⁻³")
                     .range(0, 1e18)
                     .count(1, 1000)
                     .doc_("Number density of each class, for kind: classes"))
      .parameter(
          Parameter::with_keyword(ParameterKind::Numbers, "low", "none")
              .unit_("mm⁻³")
              .range(0, 1e18)
              .count(1, 1000)
              .doc_("Lower ends of the 90 % intervals of N_V, which Compare uses. none: N_V itself, for "
                    "intervals that are unknown."))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "high", "none")
                     .unit_("mm⁻³")
                     .range(0, 1e18)
                     .count(1, 1000)
                     .doc_("Upper ends of the intervals"))
      .parameter(Parameter::optional_number("volume_fraction", "auto")
                     .range(0, 1)
                     .doc_("Volume fraction of the particles. auto: 0.3, or the one that follows from N_V or "
                           "number_density."))
      .parameter(Parameter::optional_number("number_density", "auto")
                     .unit_("mm⁻³")
                     .range(0, 1e18)
                     .doc_("Number density over all sizes. auto: the one that follows from volume_fraction."))
      .parameter(Parameter::choice("types", "mixed", {"mixed", "by_class"})
                     .doc_("mixed: particles of any shape, by the shapes' probabilities. by_class: each "
                           "shape is a separate class, which sections and Unfold distinguish."))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
