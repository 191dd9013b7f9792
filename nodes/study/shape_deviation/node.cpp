#include "graph/node_type.h"
#include "nodes/study/shape_deviation/deviation.h"
#include "runtime/context.h"

namespace terrazzo::shape_deviation {
namespace {

void compute(Context& c) {
  std::vector<const Table*> tables;
  for (const Value& v : c.list("tables")) tables.push_back(&v.as<Table>());
  std::vector<std::string> measures = c.texts("measures");
  Table t = average_deviations(tables, measures);
  c.metric("originals", tables.size());
  c.output("table", std::move(t));
  c.output("anova", effects(tables, measures));
}

}  // namespace
}  // namespace terrazzo::shape_deviation

namespace terrazzo {

NodeType shape_deviation_node() {
  using namespace shape_deviation;
  return NodeType("ShapeDeviation", 3)
      .doc_(
          "Averages the deviations of shape methods' section measures over several originals: one row per "
          "measure and kind of section, one column per method. Also tests by analysis of variance whether "
          "the measures depend on the method and on the original.")
      .source_("Jagnow, Dorsey, Rushmeier 2008, section 4.1 and table II")
      .input_list("tables", {"Table"},
                  "Tables from ShapeMetrics, one per original, with the original in the first row and the "
                  "same methods in each")
      .output("table", "Table", "Means of absolute deviations, in %, then with their signs")
      .output(
          "anova", "Table",
          "Two-way analyses of variance of each measure: effects of the method (without the originals), of "
          "the shape (one per table) and of their interaction, with F and p")
      .parameter(Parameter::texts("measures", {"area/perimeter²", "total curvature rad"})
                     .doc_("Measures to average: column names of ShapeMetrics without `mean`"))
      .compute_(compute);
}

}  // namespace terrazzo
