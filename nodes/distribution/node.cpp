#include "graph/node_type.h"
#include "nodes/distribution/size_laws.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  SizeLaw law;
  law.kind = c.text("kind");
  law.mean = c.number("mean"), law.sd = c.number("sd"), law.exponent = c.number("exponent");
  law.min = c.number("min");
  if (c.keyword("max").empty()) law.max = c.number("max");
  law.of_volume = c.text("density_by") == "volume";
  law.classes = static_cast<int>(c.integer("classes"));
  if (c.keyword("class_edges").empty()) law.class_edges = c.numbers("class_edges");
  if (c.keyword("N_V").empty()) law.N_V = c.numbers("N_V");
  if (c.keyword("volume_fraction").empty()) law.volume_fraction = c.number("volume_fraction");
  if (c.keyword("number_density").empty()) law.number_density = c.number("number_density");
  law.by_class = c.text("types") == "by_class";
  SizeDistribution d = make_distribution(law, c.optional<Shapes>("shapes"));
  double number = 0;
  for (const auto& e : d.shapes)
    for (const double v : e.N_V) number += v;
  c.metric("volume_fraction", d.volume_fraction);
  c.metric("number_density", number);
  c.metric("d_max", d.d_max);
  c.output("distribution", std::move(d));
}

}  // namespace

NodeType distribution_node() {
  return NodeType("Distribution", 1)
      .doc_(
          "Particle sizes written in the graph: by class, or as a law of number or volume. Sizes are "
          "√(4·A_max/π), a sphere's diameter.")
      .optional_input("shapes", {"Shapes"}, "what volume a size has; without them that of a sphere")
      .output("distribution", "SizeDistribution", "particles per mm³ by size class, for any shape")
      .parameter(Parameter::choice("kind", "lognormal",
                                   {"classes", "lognormal", "normal", "uniform", "rosin_rammler"})
                     .doc_("classes takes class_edges and N_V; lognormal and normal take mean and sd; "
                           "uniform min and max; rosin_rammler mean (63.2 % are smaller) and exponent"))
      .parameter(Parameter::number("mean", 5).unit_("mm").above(0).doc_("Mean size"))
      .parameter(Parameter::number("sd", 1.5).unit_("mm").above(0).doc_("Standard deviation of the sizes"))
      .parameter(Parameter::number("exponent", 3)
                     .range(0.1, 100)
                     .doc_("Spread of rosin_rammler: the larger the narrower"))
      .parameter(Parameter::number("min", 0).unit_("mm").range(0, 1e9).doc_("Smaller sizes are cut off"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "max", "auto")
                     .unit_("mm")
                     .above(0)
                     .doc_("Larger sizes are cut off; auto: where 0.1 % are left"))
      .parameter(
          Parameter::choice("density_by", "number", {"number", "volume"})
              .doc_("Whether the law tells how many particles, or how much volume, there is of a size"))
      .parameter(
          Parameter::integer("classes", 10).range(1, 1000).doc_("Equal classes that a law is cut into"))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "class_edges", "none")
                     .unit_("mm")
                     .range(0, 1e9)
                     .count(2, 1001)
                     .doc_("Of classes: n + 1 sizes, rising"))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "N_V", "none")
                     .unit_("mm⁻³")
                     .range(0, 1e18)
                     .count(1, 1000)
                     .doc_("Of classes: particles per volume in each"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "volume_fraction", "auto")
                     .range(0, 1)
                     .doc_("Share of the volume that the particles fill; auto: 0.3, or as N_V says"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "number_density", "auto")
                     .unit_("mm⁻³")
                     .range(0, 1e18)
                     .doc_("Particles per volume, all sizes together; auto: as volume_fraction says"))
      .parameter(
          Parameter::choice("types", "mixed", {"mixed", "by_class"})
              .doc_("mixed: particles of any shape, by the shapes' probabilities. by_class: each shape is a "
                    "class of its own, which sections and Unfold then tell apart"))
      .compute_(compute);
}

}  // namespace terrazzo
