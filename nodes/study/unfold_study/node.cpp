#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "graph/node_parameters.h"
#include "graph/node_type.h"
#include "nodes/common/plot/plot.h"
#include "nodes/data/indices.h"
#include "nodes/data/table.h"
#include "nodes/study/unfold_study/sample_profiles.h"
#include "nodes/study/unfold_study/study.h"
#include "runtime/context.h"

namespace terrazzo::unfold_study {
namespace {

Table::Cell cell(double v) { return std::isfinite(v) ? Table::Cell(v) : Table::Cell(std::string()); }

// True sizes and those recovered in one repetition, in the classes of the estimate, as in figure 7.
Plot panel(const std::string& name, const TrueSizes& truth, const std::vector<MethodResult>& results) {
  Plot plot;
  plot.title = name;
  plot.x_label = "size, mm";
  plot.y_label = "share of particles";
  PlotSeries actual{PlotSeries::Kind::Bars, "actual", {}, {}, {}, {}, 0};
  int color = 0;
  for (const auto& r : results) {
    ++color;
    if (r.N_V.empty()) continue;
    PlotSeries series{PlotSeries::Kind::Bars, r.method, {}, {}, {}, {}, color};
    for (std::size_t j = 0; j < r.N_V.size(); ++j) {
      const double x = (r.edges[j] + r.edges[j + 1]) / 2;
      series.x.push_back(x);
      series.y.push_back(r.N_V[j] / truth.total());
      if (plot.series.empty()) {
        actual.x.push_back(x);
        actual.y.push_back(truth.between(r.edges[j], r.edges[j + 1]) / truth.total());
      }
    }
    if (plot.series.empty()) plot.series.push_back(actual);
    plot.series.push_back(std::move(series));
  }
  return plot;
}

void check(const NodeParameters& p) {
  for (const auto& m : p.texts("methods"))
    if (m != "em" && m != "nnls" && m != "inverse" && m != "equation 4")
      throw Error("unknown-method", "unknown method \"" + m + "\"", "use em, nnls, inverse or equation 4")
          .parameter("methods");
}

void compute(Context& c) {
  StudyOptions o;
  o.methods = c.texts("methods");
  o.repetitions = c.integer("repetitions");
  o.profiles = c.integer("profiles");
  o.sections = c.integer("sections");
  o.classes = c.integer("classes");
  o.largest = c.choice<LargestSize>("d_max");
  o.bootstrap = c.integer("bootstrap");
  o.seed = c.seed();
  const auto& truths = c.list("distributions");
  std::vector<std::string> names = c.keyword("names").empty() ? c.texts("names") : std::vector<std::string>{};
  if (!names.empty() && names.size() != truths.size())
    throw Error("wrong-count",
                fmt::format("there are {} names for {} distributions", names.size(), truths.size()),
                "set one name per distribution, or none")
        .parameter("names");

  Table table, densities;
  table.columns = {"distribution",   "method",     "L1 error",
                   "standard error", "N_V / true", "coverage of 90 % intervals",
                   "refused"};
  densities.columns = {"distribution", "method", "from mm", "to mm", "N_V true mm⁻³", "N_V mm⁻³", "coverage"};
  std::vector<Plot> panels;
  for (std::size_t t = 0; t < truths.size(); ++t) {
    const auto share = [&](std::size_t i) { return static_cast<double>(i) / truths.size(); };
    const auto& distribution = truths[t].as<SizeDistribution>();
    const TrueSizes truth(distribution);
    const auto results =
        study(distribution, c.input<KMatrix>("kmatrix"), o, c.work().part(share(t), share(t + 1)));
    const std::string name = names.empty() ? fmt::format("distribution {}", t + 1) : names[t];
    for (const auto& r : results) {
      table.rows.push_back({name, r.method, cell(r.error), cell(r.error_of_mean), cell(r.total),
                            cell(r.coverage), static_cast<double>(r.refused)});
      for (std::size_t j = 0; j < r.N_V.size(); ++j)
        densities.rows.push_back({name, r.method, r.edges[j], r.edges[j + 1],
                                  truth.between(r.edges[j], r.edges[j + 1]), r.N_V[j],
                                  cell(r.class_coverage[j])});
      if (r.refused > 0)
        c.warn(
            fmt::format("{} of {} repetitions of {} on {} failed with impossible densities; they are "
                        "excluded from the means",
                        r.refused, o.repetitions, r.method, name));
      if (std::isfinite(r.error)) c.metric(fmt::format("error {} {}", name, r.method), r.error);
      if (std::isfinite(r.coverage)) c.metric(fmt::format("coverage {} {}", name, r.method), r.coverage);
    }
    panels.push_back(panel(name, truth, results));
  }
  c.output("table", std::move(table));
  c.output("densities", std::move(densities));
  c.output("figure", draw(panels, std::min<int>(2, count_of(panels))));
}

}  // namespace
}  // namespace terrazzo::unfold_study

namespace terrazzo {

NodeType unfold_study_node() {
  using namespace unfold_study;
  return NodeType("UnfoldStudy", 8)
      .doc_(
          "Measures how well unfolding recovers known sizes. Draws the profiles that random planes would "
          "show and unfolds them with every method, many times. All methods see the same profiles. Settings "
          "not listed here are Unfold's defaults.")
      .source_("Jagnow, Dorsey, Rushmeier 2004, section 5.1 and figure 7")
      .input_list("distributions", {"SizeDistribution"}, "True size distributions, one panel each")
      .input("kmatrix", "KMatrix",
             "Section statistics of the particle shapes, for both sampling and unfolding")
      .output("table", "Table",
              "Mean of Σ|ΔN_V|/ΣN_V for each distribution and method, with its standard error")
      .output("densities", "Table",
              "True and recovered N_V by class, from the first successful repetition, and the coverage of "
              "the intervals of the class with this number in all; unless d_max: known, its edges differ")
      .output("figure", "Image", "Bar charts of the same densities, as in figure 7")
      .parameter(Parameter::texts("methods", {"em", "nnls", "inverse", "equation 4"})
                     .doc_("Unfolding methods to compare: em, nnls and inverse (as in Unfold), and equation "
                           "4, the paper's method: inverse with all sizes of a class at its upper edge."))
      .parameter(Parameter::integer("repetitions", 10).range(1, 10000).doc_("Number of observations drawn"))
      .parameter(
          Parameter::integer("profiles", 1200)
              .range(3, 5000000)
              .doc_("Expected number of profiles per observation. The actual number is Poisson distributed."))
      .parameter(Parameter::integer("sections", 1)
                     .range(1, 10000)
                     .doc_("Number of sections that the profiles are spread over. With 10 or more, the "
                           "intervals resample whole sections."))
      .parameter(Parameter::integer("classes", 10).range(1, 200).doc_("Number of size classes to recover"))
      .parameter(
          Parameter::choice("d_max", "estimated", {"estimated", "known", "largest_profile"})
              .doc_("Upper end of the size classes. estimated: as Unfold estimates it. known: the "
                    "largest true size; it also sets smallest_visible to 0. largest_profile: the size whose "
                    "largest section is the largest profile (equation 7), which is too small."))
      .parameter(
          Parameter::integer("bootstrap", 0)
              .range(0, 100000)
              .doc_("Number of bootstrap repetitions per observation for the intervals of em and "
                    "nnls. Their coverage is then reported, over classes whose particles show at least one "
                    "profile on average. 0: no intervals."))
      .parameter(
          Parameter::with_keyword(ParameterKind::Texts, "names", "none").doc_("Names of the distributions"))
      .parameter(Parameter::seed().doc_("Random seed of the profiles"))
      .check_(check)
      .compute_(compute);
}

}  // namespace terrazzo
