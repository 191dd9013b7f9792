#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/shapes/shape_metrics/metrics.h"
#include "runtime/context.h"

namespace terrazzo::shape_metrics {
namespace {

struct Population {
  std::string name;
  Shapes shapes;
};

enum class Rows { Auto, Shape, Set };

Shapes alone(const Shape& s) {
  Shapes one;
  one.shapes.push_back(s);
  one.shapes[0].probability = 1;
  return one;
}

std::vector<Population> populations(const Context& c) {
  const auto& wires = c.list("shapes");
  const auto rows = c.choice<Rows>("rows");
  const bool sets = rows == Rows::Set || (rows == Rows::Auto && wires.size() > 1);
  std::vector<Population> out;
  for (const Value& v : wires) {
    const auto& shapes = v.as<Shapes>();
    if (sets) {
      out.push_back({fmt::format("set {}", out.size() + 1), shapes});
    } else {
      for (const Shape& s : shapes.shapes) out.push_back({s.name, alone(s)});
    }
  }
  if (out.empty()) throw Error("no-shapes", "there are no shapes to measure", "connect at least one shape");
  for (const auto& p : out) {
    if (p.shapes.shapes.empty())
      throw Error("no-shapes", p.name + " has no shapes", "check the node that produces them");
    for (const Shape& s : p.shapes.shapes)
      if (const auto faults = mesh_faults(s.mesh); !faults.empty())
        throw Error("open-mesh", fmt::format("the shape '{}' is not watertight: {}", s.name, faults[0]));
  }
  if (c.keyword("names").empty()) {
    const auto names = c.texts("names");
    if (names.size() != out.size())
      throw Error("bad-names", fmt::format("there are {} names for {} rows", names.size(), out.size()),
                  "set one name per row, in the order of the wires")
          .parameter("names");
    for (std::size_t i = 0; i < out.size(); ++i) out[i].name = names[i];
  }
  return out;
}

void compute(Context& c) {
  MetricsOptions choice;
  choice.sections = c.integer("sections");
  choice.seed = c.seed();
  choice.measuring.points = c.integer("points");
  const auto all = populations(c);
  std::vector<MetricsRow> rows;
  const double n = all.size();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double from = i / n;
    rows.push_back(
        {all[i].name,
         summarize(all[i].shapes, SectionKind::Central, choice, c.work().part(from, from + 0.5 / n)),
         summarize(all[i].shapes, SectionKind::Random, choice, c.work().part(from + 0.5 / n, from + 1 / n))});
  }
  c.metric("shapes", n);
  c.metric("circularity_central", rows[0].central.mean[0]);
  c.metric("circularity_random", rows[0].random.mean[0]);
  c.metric("total_curvature_central", rows[0].central.mean[1]);
  c.metric("total_curvature_random", rows[0].random.mean[1]);
  c.output("table", table_of(rows));
  c.output("figure", figure_of(rows));
}

}  // namespace
}  // namespace terrazzo::shape_metrics

namespace terrazzo {

NodeType shape_metrics_node() {
  using namespace shape_metrics;
  return NodeType("ShapeMetrics", 2)
      .doc_(
          "Describes the sections of shapes: mean and standard deviation of area/perimeter² and total "
          "curvature over central and random sections, and of curvature along the outline, symmetry, "
          "anisotropy and corners.")
      .source_("Jagnow, Dorsey, Rushmeier 2008, section 4.1, figure 13; measures suggested in section 5")
      .input_list("shapes", {"Shapes"},
                  "One set, each shape of which is measured, or several sets, each measured as a population. "
                  "Rows are compared with the first.")
      .output("table", "Table",
              "One row per shape or set and kind of section: mean, standard deviation and deviation from the "
              "first row for each measure")
      .output("figure", "Image", "Means with standard deviations, and distributions of curvature")
      .parameter(Parameter::integer("sections", 10000)
                     .range(1, 10000000)
                     .doc_("Number of central sections, and of random sections, per row"))
      .parameter(Parameter::seed().doc_("Random seed of the section planes"))
      .parameter(Parameter::integer("points", 128)
                     .range(32, 1024)
                     .doc_("Number of equidistant points at which an outline is measured, so that its "
                           "tessellation does not matter"))
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "names", "auto").doc_("Names of the rows"))
      .parameter(Parameter::choice("rows", "auto", {"auto", "shape", "set"})
                     .doc_("shape: one row per shape. set: one row per set of shapes, weighted by their "
                           "probabilities. auto: shape for a single set, set for several."))
      .compute_(compute);
}

}  // namespace terrazzo
