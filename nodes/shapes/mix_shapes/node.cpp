#include "graph/node_type.h"
#include "nodes/shapes/mix_shapes/mix_shapes.h"
#include "runtime/context.h"

namespace terrazzo::mix_shapes {
namespace {

void compute(Context& c) {
  std::vector<const Shapes*> sets;
  for (const Value& v : c.list("shapes")) sets.push_back(&v.as<Shapes>());
  const std::vector<double> shares =
      c.keyword("shares").empty() ? c.numbers("shares") : std::vector<double>(sets.size(), 1.0);
  Shapes all = mix(sets, shares);
  c.metric("shapes", all.shapes.size());
  c.output("shapes", std::move(all));
}

}  // namespace
}  // namespace terrazzo::mix_shapes

namespace terrazzo {

NodeType mix_shapes_node() {
  using namespace mix_shapes;
  return NodeType("MixShapes", 1)
      .doc_("Joins shapes from several sources into one population with the given shares by number.")
      .source_("Jagnow, Dorsey, Rushmeier 2004, section 3.3 (P(i) of eq. 10 to 12)")
      .input_list("shapes", {"Shapes"},
                  "Sets of shapes. Shapes within a set keep their relative probabilities.")
      .output("shapes", "Shapes", "All shapes, with probabilities that sum to 1")
      .parameter(Parameter::with_keyword(ParameterKind::Numbers, "shares", "equal")
                     .range(0, 1e12)
                     .doc_("Share of each set, by number of particles. Shares need not sum to 1."))
      .compute_(compute);
}

}  // namespace terrazzo
