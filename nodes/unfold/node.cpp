#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/common/plot.h"
#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/unfold/summary.h"
#include "nodes/unfold/unfold.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

Table table_of(const UnfoldResult& r, const SizeSummary& summary) {
  Table t;
  t.columns = {"class",    "from mm",      "to mm",         "N_A observed mm⁻²",   "N_A refitted mm⁻²",
               "N_V mm⁻³", "N_V low mm⁻³", "N_V high mm⁻³", "share of the volume", "volume passing"};
  for (std::size_t c = 0; c < r.fits.size(); ++c)
    for (int j = 0; j < r.model.visible(); ++j) {
      const auto k = static_cast<std::size_t>(r.model.first + j);
      double low = 0, high = 0;
      for (const auto& e : r.distribution.shapes)
        if (e.cls == static_cast<int>(c)) low += e.low[k], high += e.high[k];
      auto& row = t.rows.emplace_back();
      for (const double v :
           {static_cast<double>(c), r.distribution.class_edges[k], r.distribution.class_edges[k + 1],
            r.fits[c].observed[j], r.fits[c].refitted[j], r.fits[c].density[j], low, high,
            summary.volume_share[k], summary.volume_passing[k]})
        row.emplace_back(v);
    }
  return t;
}

Image figure_of(const UnfoldResult& r, const SizeSummary& summary) {
  Plot areas, volumes, sieve;
  areas.title = "Profiles per area", areas.x_label = "size of the profile, mm", areas.y_label = "N_A, mm⁻²";
  volumes.title = "Particles per volume", volumes.x_label = "size of the particle, mm",
  volumes.y_label = "N_V, mm⁻³";
  PlotSeries observed{PlotSeries::Kind::Bars, "observed", {}, {}, {}, {}, 0};
  PlotSeries refitted{PlotSeries::Kind::Bars, "refitted", {}, {}, {}, {}, 1};
  PlotSeries density{PlotSeries::Kind::Bars, "", {}, {}, {}, {}, 2};
  for (int j = 0; j < r.model.visible(); ++j) {
    const auto k = static_cast<std::size_t>(r.model.first + j);
    const double x = (r.model.edges[k] + r.model.edges[k + 1]) / 2;
    double a = 0, b = 0, v = 0, low = 0, high = 0;
    for (const auto& f : r.fits) a += f.observed[j], b += f.refitted[j], v += f.density[j];
    for (const auto& e : r.distribution.shapes) low += e.low[k], high += e.high[k];
    observed.x.push_back(x), observed.y.push_back(a);
    refitted.x.push_back(x), refitted.y.push_back(b);
    density.x.push_back(x), density.y.push_back(v);
    density.low.push_back(low), density.high.push_back(high);
  }
  areas.series = {observed, refitted};
  volumes.series = {density};
  sieve.title = "Sieve curve", sieve.x_label = "size of the particle, mm",
  sieve.y_label = "share of the volume that passes";
  PlotSeries passing{PlotSeries::Kind::Line, "", {}, {}, {}, {}, 2};
  for (std::size_t k = static_cast<std::size_t>(r.model.first); k <= summary.volume_passing.size(); ++k)
    passing.x.push_back(r.model.edges[k]), passing.y.push_back(k > 0 ? summary.volume_passing[k - 1] : 0);
  sieve.series = {passing};
  return draw({areas, volumes, sieve}, 3);
}

void compute(Context& c) {
  UnfoldOptions o;
  o.method = c.text("method");
  if (c.keyword("classes").empty()) o.classes = static_cast<int>(c.integer("classes"));
  if (c.keyword("smallest_visible").empty()) o.smallest_visible = c.number("smallest_visible");
  const std::string border = c.text("border");
  o.border = border == "weights" ? Border::Weights : border == "all" ? Border::All : Border::Inside;
  if (c.keyword("d_max").empty()) o.d_max = c.number("d_max");
  o.area_fraction = c.number("area_fraction");
  o.by_class = c.text("types") == "by_class";
  o.bootstrap = static_cast<int>(c.integer("bootstrap"));
  o.seed = static_cast<std::uint64_t>(c.integer("seed"));
  UnfoldResult r = unfold(c.input<Profiles>("profiles"), c.input<KMatrix>("kmatrix"), o, c.work());
  double fraction = 0, negative = 0, freedom = 0, jumps = 0;
  for (const auto& q : r.observations.classes) fraction += q.area_fraction;
  for (const auto& f : r.fits) {
    negative = std::max(negative, f.negative), freedom += f.freedom, jumps += f.jumps;
  }
  if (negative > 0)
    c.warn(
        fmt::format("{:.0f} % of the densities came out negative and were set to zero; method: em "
                    "constrains them instead",
                    100 * negative));
  if (!r.observations.relative && std::abs(r.distribution.volume_fraction - fraction) > 0.1 * fraction)
    c.warn(fmt::format("the densities fill {:.3g} of the volume, but profiles cover {:.3g} of the section",
                       r.distribution.volume_fraction, fraction));
  const int asked = c.input<KMatrix>("kmatrix").classes;
  if (o.classes == 0 && r.model.classes() < asked)
    c.warn(fmt::format(
        "{} profiles tell {} classes apart, not the {} of the K matrix; set classes to have another "
        "number",
        r.observations.used, r.model.classes(), asked));
  if (r.observations.relative)
    c.warn(
        "the area observed is unknown: densities are relative, their sum is 1; set observed_area where the "
        "profiles are loaded, or area_fraction here");
  if (static_cast<int>(r.observations.used) < r.model.visible())
    c.warn(fmt::format("{} profiles for {} classes: use fewer classes or a larger picture",
                       r.observations.used, r.model.visible()));
  c.metric("classes", r.model.classes());
  c.metric("freedom", freedom);
  if (o.method == "em") c.metric("jumps", jumps);
  c.metric("profiles_used", static_cast<double>(r.observations.used));
  c.metric("area_fraction", fraction);
  c.metric("volume_fraction", r.distribution.volume_fraction);
  c.metric("d_max", r.distribution.d_max);
  c.metric("goodness_of_fit", r.distribution.goodness_of_fit);
  c.metric("condition", r.condition);
  c.metric("negative", negative);
  const SizeSummary summary = summarise(r.distribution);
  if (!r.observations.relative) c.metric("N_V", summary.N_V);
  c.metric("mean_size", summary.mean);
  c.metric("median_size", summary.median);
  c.metric("geometric_mean", summary.geometric_mean);
  c.metric("geometric_sd", summary.geometric_sd);
  c.metric("volume_d10", summary.d10), c.metric("volume_d50", summary.d50),
      c.metric("volume_d90", summary.d90);
  c.output("table", table_of(r, summary));
  c.output("figure", figure_of(r, summary));
  c.output("distribution", std::move(r.distribution));
}

}  // namespace

NodeType unfold_node() {
  return NodeType("Unfold", 5)
      .doc_(
          "Recovers how many particles of each size a volume holds from the sizes of profiles in its "
          "sections. Colour classes are unfolded each on its own, shapes mixed by their probabilities.")
      .source_("Jagnow, Dorsey, Rushmeier 2004, section 3, eq. 8 and 12; Silverman et al. 1990 (em)")
      .input("profiles", "Profiles", "What sections show; with the area observed")
      .input("kmatrix", "KMatrix", "Section statistics of the particles' shapes")
      .output("distribution", "SizeDistribution",
              "Particles per mm³ by size class, for each colour class and shape")
      .output(
          "table", "Table",
          "N_A observed and refitted, N_V with its interval, by class; all colours together the share of the "
          "volume and how much of it is smaller (the sieve curve)")
      .output("figure", "Image", "Profiles and particles as bars, and the sieve curve")
      .parameter(
          Parameter::choice("method", "em", {"em", "nnls", "inverse"})
              .doc_(
                  "em: maximum likelihood of the counts with densities that vary as smoothly as the counts "
                  "ask "
                  "for. nnls: densities of at least zero and least squared error, each class weighted by its "
                  "counting error. Both hold the volume fraction to the profiles' area fraction. inverse: "
                  "the "
                  "paper's K⁻¹; negative densities are reported and set to zero"))
      .parameter(Parameter::with_keyword(ParameterKind::Int, "classes", "auto")
                     .range(1, 200)
                     .doc_("Equal size classes from 0 to d_max; auto: as many as the K matrix has, but no "
                           "more than 2·n^⅓ for n "
                           "profiles"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "smallest_visible", "auto")
                     .unit_("mm")
                     .range(0, 1e9)
                     .doc_("Size of the smallest profile that would have been seen: smaller ones are "
                           "missing, not absent; auto: the smallest that was"))
      .parameter(
          Parameter::choice("border", "weights", {"weights", "inside", "all"})
              .doc_("weights: profiles cut by the border left out and the others weighted for it (Miles and "
                    "Lantuéjoul); inside: left out; all: every profile counts as it is seen"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "d_max", "auto")
                     .unit_("mm")
                     .above(0)
                     .doc_("Size of the largest particle; auto: by maximum likelihood, at least that of the "
                           "largest profile"))
      .parameter(
          Parameter::number("area_fraction", 0)
              .range(0, 1)
              .doc_(
                  "Share of the section that profiles cover, where the profiles come without it; 0: unknown"))
      .parameter(
          Parameter::choice("types", "mixed", {"mixed", "by_class"})
              .doc_("What a colour class is made of: mixed: all shapes by their probabilities (eq. 10 to "
                    "12); by_class: class 0 of the first shape, class 1 of the second … (eq. 9)"))
      .parameter(Parameter::integer("bootstrap", 100)
                     .range(0, 100000)
                     .doc_("Repetitions for the 90 % intervals: profiles drawn again, from ten sections on "
                           "whole sections; em draws what smoothing hides too; 0: none"))
      .parameter(Parameter::integer("seed", 1).range(0, 9007199254740991).doc_("Of the bootstrap"))
      .compute_(compute);
}

}  // namespace terrazzo
