#include <numeric>

#include "graph/node_type.h"
#include "nodes/distribution/size_law.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

void compute(Context& c) {
  const auto number = [&](const std::string& name) { return c.keyword(name).empty() ? c.number(name) : 0; };
  DistributionOptions o;
  o.kind = c.text("kind");
  o.mean = c.number("mean"), o.sd = c.number("sd");
  o.min = c.number("min"), o.max = number("max");
  o.classes = static_cast<int>(c.integer("classes"));
  if (c.keyword("class_edges").empty()) o.class_edges = c.numbers("class_edges");
  if (c.keyword("N_V").empty()) o.N_V = c.numbers("N_V");
  o.volume_fraction = number("volume_fraction"), o.number_density = number("number_density");
  const std::string by = c.text("density_by");
  o.by_volume = by == "volume" || (by == "auto" && o.kind == "rosin_rammler");
  SizeDistribution d = make_distribution(o, c.optional<Shapes>("shapes"));
  c.metric("volume_fraction", d.volume_fraction);
  c.metric("N_V", std::accumulate(d.shapes[0].N_V.begin(), d.shapes[0].N_V.end(), 0.0));
  c.metric("d_max", d.d_max);
  c.output("distribution", std::move(d));
}

}  // namespace

NodeType distribution_node() {
  return NodeType("Distribution", 1)
      .doc_(
          "Particle sizes written in the graph: densities per class, or a law of size. A particle's size is "
          "√(4·A_max/π), "
          "A_max being its largest section: a sphere's diameter. Within a class sizes are uniform.")
      .source_("Class integrals in closed form; Rosin and Rammler 1933")
      .optional_input("shapes", {"Shapes"}, "Whose volumes count for volume_fraction; spheres without them")
      .output("distribution", "SizeDistribution", "Particles per mm³ and size class")
      .parameter(Parameter::choice("kind", "lognormal",
                                   {"classes", "lognormal", "normal", "uniform", "rosin_rammler"})
                     .doc_("classes takes class_edges and N_V; the others are laws of size"))
      .parameter(Parameter::number("mean", 1).unit_("mm").above(0).doc_(
          "Mean size of the law before it is cut to min and max"))
      .parameter(
          Parameter::number("sd", 0.3).unit_("mm").above(0).doc_("Standard deviation of size, likewise"))
      .parameter(Parameter::number("min", 0).unit_("mm").range(0, 1e12).doc_("Smallest size"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "max", "auto")
                     .unit_("mm")
                     .above(0)
                     .doc_("Largest size; auto: the last of class_edges, else where 0.1 % of the law lies "
                           "above. A uniform "
                           "law must have it."))
      .parameter(Parameter::integer("classes", 10)
                     .range(1, 1000)
                     .doc_("Equal classes from min to max, where class_edges is auto"))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "class_edges", "auto")
                     .unit_("mm")
                     .doc_("Rising sizes, one more than there are classes"))
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "N_V", "auto")
                     .unit_("per mm³")
                     .doc_("Of kind classes: particles per class; relative where volume_fraction or "
                           "number_density is given"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "volume_fraction", "none")
                     .above(0)
                     .range(0, 1)
                     .doc_("Share of the volume that particles fill"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "number_density", "none")
                     .unit_("per mm³")
                     .above(0)
                     .doc_("Particles per volume, all sizes together"))
      .parameter(
          Parameter::choice("density_by", "auto", {"auto", "number", "volume"})
              .doc_("Whether law and N_V tell the share of number or of volume by size; auto: volume for "
                    "rosin_rammler, a law of sieved mass, number otherwise"))
      .compute_(compute);
}

}  // namespace terrazzo
