#include "nodes/packing/request.h"

namespace terrazzo::packing {

NodeType& declare_population(NodeType& type) {
  return type
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "size", "auto")
                     .unit_("mm")
                     .above(0)
                     .count(1, 3)
                     .doc_("Edge length of the box: one value for a cube, two for x = y and z, or three for "
                           "x, y and z. auto: a cube for about `count` particles, at least three times the "
                           "largest particle unless that would need ten times as many."))
      .parameter(Parameter::integer("count", 2000)
                     .range(1, 1000000)
                     .doc_("Number of particles for which an automatic box is sized"))
      .parameter(Parameter::seed().doc_("Random seed of positions, orientations and sizes"))
      .parameter(Parameter::choice("conserve", "volume_fraction", {"volume_fraction", "number_density"})
                     .doc_("Quantity to keep if the shapes' volumes contradict the distribution's volume "
                           "fraction. volume_fraction: scale all number densities to keep the volume "
                           "fraction. number_density: keep the number densities."));
}

PopulationOptions read_population(const Context& c) {
  PopulationOptions o;
  if (c.keyword("size") != "auto") o.edges = c.numbers("size");
  o.count = c.integer("count");
  o.conserve = c.choice<Conserve>("conserve");
  o.seed = c.seed();
  return o;
}

}  // namespace terrazzo::packing
