#include <fmt/format.h>

#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/plot/plot.h"
#include "nodes/data/table.h"
#include "nodes/study/shape_observer/observer.h"
#include "runtime/context.h"

namespace terrazzo::shape_observer {
namespace {

void check(const NodeParameters& p) {
  if (static_cast<double>(p.integer("profiles")) * p.integer("views") > 5e6)
    throw Error("too-many-profiles",
                fmt::format("views × profiles must be at most 5 million; there are {} views of {} profiles",
                            p.integer("views"), p.integer("profiles")),
                "lower views or profiles")
        .parameter("views");
}

void compute(Context& c) {
  const auto& wires = c.list("shapes");
  if (wires.size() < 2)
    throw Error("no-decoys",
                fmt::format("at least two sets of shapes are needed; there are {}", wires.size()),
                "connect the original, then decoys");
  std::vector<std::string> names;
  if (c.keyword("names").empty()) {
    names = c.texts("names");
    if (names.size() != wires.size())
      throw Error("bad-names",
                  fmt::format("there are {} names for {} sets of shapes", names.size(), wires.size()),
                  "set one name per wire, the original's first")
          .parameter("names");
  } else {
    for (std::size_t i = 0; i < wires.size(); ++i)
      names.push_back(i ? fmt::format("decoy {}", i) : "original");
  }
  ObserverOptions choice;
  choice.profiles = c.integer("profiles");
  choice.views = c.integer("views");
  choice.eyesight = c.number("eyesight");
  choice.seed = c.seed();
  Table t;
  t.columns = {"name", "accuracy %", "standard error %", "main feature"};
  Plot plot;
  plot.title = fmt::format("decoys found among pairs of views of {} profile{}", choice.profiles,
                           choice.profiles == 1 ? "" : "s");
  plot.y_label = "%";
  PlotSeries bars;
  bars.kind = PlotSeries::Kind::Bars;
  for (std::size_t i = 1; i < wires.size(); ++i) {
    const double from = (static_cast<double>(i) - 1) / (wires.size() - 1);
    const auto v = observe(wires[0].as<Shapes>(), wires[i].as<Shapes>(), choice,
                           c.work().part(from, from + 1.0 / (wires.size() - 1)));
    t.rows.push_back({names[i], 100 * v.told, 100 * v.error, v.by});
    plot.x_words.push_back(names[i]);
    bars.x.push_back(static_cast<double>(i) - 1);
    bars.y.push_back(100 * v.told);
    bars.low.push_back(100 * (v.told - v.error));
    bars.high.push_back(100 * (v.told + v.error));
  }
  plot.series.push_back(std::move(bars));
  c.output("table", std::move(t));
  c.output("figure", draw(plot));
}

}  // namespace
}  // namespace terrazzo::shape_observer

namespace terrazzo {

NodeType shape_observer_node() {
  using namespace shape_observer;
  return NodeType("ShapeObserver", 4)
      .doc_(
          "Simulates a human observer: how accurately a cross-validated classifier on section features "
          "distinguishes a view of a decoy from a view of the original. 50 % is chance.")
      .source_("replaces the user study of Jagnow, Dorsey, Rushmeier 2008, section 4.2; Fisher 1936")
      .input_list("shapes", {"Shapes"}, "The original, then decoys")
      .output("table", "Table",
              "One row per decoy: classification accuracy over pairs in %, standard error, and most "
              "discriminating feature")
      .output("figure", "Image", "Bar chart of the accuracies")
      .parameter(Parameter::integer("profiles", 20)
                     .range(1, 2000)
                     .doc_("Number of profiles per view. An image of the study shows about 260."))
      .parameter(
          Parameter::integer("views", 180)
              .range(18, 20000)
              .doc_("Number of views of the original and of each decoy, and number of pairs classified"))
      .parameter(
          Parameter::number("eyesight", 1)
              .range(0, 100)
              .doc_("Error with which each measure of a profile is read, in units of what is just visible in "
                    "an image of about 16 pixels. 0: exact, down to the triangles of a mesh."))
      .parameter(Parameter::integer("seed", 1).range(0, 4503599627370495).doc_("Random seed of the sections"))
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "names", "auto")
                     .doc_("Names of the original and the decoys"))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
