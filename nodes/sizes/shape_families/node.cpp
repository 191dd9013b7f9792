#include <fmt/format.h>

#include <algorithm>

#include "graph/node_type.h"
#include "nodes/common/plot/plot.h"
#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/sizes/shape_families/score.h"
#include "runtime/context.h"

namespace terrazzo::shape_families {
namespace {

constexpr double kDisagree = 1.1;  // ratio of densities from which families that predict alike are reported

Table table_of(const std::vector<Family>& families, const Scores& scores) {
  Table t;
  const auto per_volume = [&](const char* name) {
    return fmt::format("{} {}", name, scores.relative ? "relative" : "mm⁻³");
  };
  t.columns = {"family",
               "sizes",
               "outlines",
               "behind",
               "standard error",
               "plausible",
               per_volume("N_V"),
               per_volume("N_V low"),
               per_volume("N_V high"),
               "mean size mm",
               "goodness of fit"};
  for (std::size_t f = 0; f < families.size(); ++f) {
    const FamilyScore& s = scores.families[f];
    auto& row = t.rows.emplace_back();
    row.emplace_back(families[f].name);
    for (const double v : {s.sizes, s.outlines, s.behind, s.error, s.plausible ? 1.0 : 0.0, s.N_V, s.low,
                           s.high, s.mean_size, s.goodness_of_fit})
      row.emplace_back(v);
  }
  return t;
}

Image figure_of(const std::vector<Family>& families, const Scores& scores) {
  Plot prediction, density;
  prediction.title = "Prediction of held-out profiles";
  prediction.y_label = "log density per profile, behind the best";
  density.title = "Particles per volume by family";
  density.y_label = scores.relative ? "N_V, relative" : "N_V, mm⁻³";
  PlotSeries behind{PlotSeries::Kind::Points, "", {}, {}, {}, {}, 0};
  PlotSeries likely{PlotSeries::Kind::Bars, "plausible", {}, {}, {}, {}, 2};
  PlotSeries unlikely{PlotSeries::Kind::Bars, "not plausible", {}, {}, {}, {}, 1};
  for (std::size_t f = 0; f < families.size(); ++f) {
    const FamilyScore& s = scores.families[f];
    const double x = f;
    behind.x.push_back(x);
    behind.y.push_back(s.behind);
    behind.low.push_back(s.behind - 2 * s.error);
    behind.high.push_back(s.behind + 2 * s.error);
    PlotSeries& bars = s.plausible ? likely : unlikely;
    bars.x.push_back(x);
    bars.y.push_back(s.N_V);
    bars.low.push_back(s.low);
    bars.high.push_back(s.high);
    prediction.x_words.push_back(families[f].name);
    density.x_words.push_back(families[f].name);
  }
  prediction.series = {behind};
  for (const PlotSeries& bars : {likely, unlikely})
    if (!bars.x.empty()) density.series.push_back(bars);
  return draw({prediction, density}, 2);
}

std::vector<Family> families_of(Context& c) {
  const auto shapes = c.list("shapes"), matrices = c.list("kmatrices");
  if (shapes.size() != matrices.size())
    throw Error("wrong-count",
                fmt::format("there are {} sets of shapes, but {} K matrices", shapes.size(), matrices.size()),
                "connect one K matrix per set of shapes, in the same order");
  const auto names = c.texts("names");
  if (!names.empty() && names.size() != shapes.size())
    throw Error("wrong-count", fmt::format("there are {} names for {} families", names.size(), shapes.size()),
                "give every family a name")
        .parameter("names");
  std::vector<Family> out;
  for (std::size_t f = 0; f < shapes.size(); ++f)
    out.push_back({names.empty() ? fmt::format("family {}", f + 1) : names[f], &shapes[f].as<Shapes>(),
                   &matrices[f].as<KMatrix>()});
  return out;
}

void warn_of_disagreement(Context& c, const std::vector<Family>& families, const Scores& scores) {
  std::size_t low = scores.best, high = scores.best;
  for (std::size_t f = 0; f < families.size(); ++f) {
    if (!scores.families[f].plausible) continue;
    if (scores.families[f].N_V < scores.families[low].N_V) low = f;
    if (scores.families[f].N_V > scores.families[high].N_V) high = f;
  }
  const double least = scores.families[low].N_V, most = scores.families[high].N_V;
  if (scores.relative) return;
  c.metric("N_V", scores.families[scores.best].N_V);
  c.metric("N_V_least", least);
  c.metric("N_V_most", most);
  if (most > kDisagree * least)
    c.warn(fmt::format(
        "the profiles fit {} and {} about equally well, but N_V is {:.3g} mm⁻³ with {} and "
        "{:.3g} mm⁻³ with {}",
        families[low].name, families[high].name, least, families[low].name, most, families[high].name));
}

void compute(Context& c) {
  const std::vector<Family> families = families_of(c);
  ScoreOptions s;
  s.folds = c.integer("folds");
  s.sections = c.integer("sections");
  if (const auto v = c.optional_number("smallest_visible")) s.smallest_visible = *v;
  s.bootstrap = c.integer("bootstrap");
  s.seed = c.seed();
  const Scores scores = score_families(c.input<Profiles>("profiles"), families, s, c.work());
  if (scores.outlines == 0)
    c.warn(
        "no profile has an outline that can be measured, so only sizes are compared; they say little about "
        "shapes");
  c.metric("profiles", scores.profiles);
  c.metric("outlines", scores.outlines);
  c.metric("best", scores.best);
  c.metric("plausible", std::count_if(scores.families.begin(), scores.families.end(),
                                      [](const auto& f) { return f.plausible; }));
  warn_of_disagreement(c, families, scores);
  c.output("table", table_of(families, scores));
  c.output("figure", figure_of(families, scores));
  c.output("shapes", *families[scores.best].shapes);
  c.output("kmatrix", *families[scores.best].kmatrix);
}

}  // namespace
}  // namespace terrazzo::shape_families

namespace terrazzo {

NodeType shape_families_node() {
  using namespace shape_families;
  return NodeType("ShapeFamilies", 5)
      .doc_(
          "Compares families of particle shapes by how well they predict profiles that were held out, and "
          "reports how much the number of particles depends on the choice.")
      .source_(
          "Geisser and Eddy 1979 (predictive sample reuse); Jagnow, Dorsey, Rushmeier 2004, section 3 "
          "(unfolding); 2008, section 4.1 (outlines)")
      .input("profiles", "Profiles", "Profiles observed in the sections")
      .input_list("shapes", {"Shapes"}, "The families: a set of shapes each")
      .input_list("kmatrices", {"KMatrix"}, "Section statistics of each family, in the same order")
      .output("table", "Table",
              "By family: mean log predictive density of sizes and of outlines per profile, both relative to "
              "the best family with its standard error, N_V with its 90 % interval, mean size, fit")
      .output("figure", "Image", "Predictions with two standard errors, and N_V by family")
      .output("shapes", "Shapes", "The shapes of the family that predicts best")
      .output("kmatrix", "KMatrix", "Its section statistics")
      .parameter(Parameter::texts("names", {})
                     .count(0, 64)
                     .doc_("Name of each family, for the table and the figure. []: numbers."))
      .parameter(Parameter::integer("folds", 5)
                     .range(2, 20)
                     .doc_("Number of parts of the profiles. Each is predicted from the others."))
      .parameter(Parameter::integer("sections", 3000)
                     .range(100, 100000)
                     .doc_("Number of random sections of each family whose outlines are measured"))
      .parameter(Parameter::optional_number("smallest_visible", "auto")
                     .unit_("mm")
                     .range(0, 1e9)
                     .doc_("Size of the smallest profile that the photograph can show, as in Unfold. auto: "
                           "the smallest profile observed."))
      .parameter(Parameter::integer("bootstrap", 40)
                     .range(0, 100000)
                     .doc_("Number of bootstrap repetitions for the 90 % intervals. 0: no intervals."))
      .parameter(Parameter::seed().doc_("Random seed of the folds, the sections and the bootstrap"))
      .compute_(compute);
}

}  // namespace terrazzo
