#include <numeric>

#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/unfold/report.h"
#include "nodes/unfold/unfold.h"
#include "runtime/context.h"

namespace terrazzo {
namespace {

double number_or_zero(const Context& c, const std::string& name) {
  return c.keyword(name).empty() ? c.number(name) : 0;
}

void compute(Context& c) {
  const auto& profiles = c.input<Profiles>("profiles");
  const auto& kmatrix = c.input<KMatrix>("kmatrix");
  UnfoldOptions options;
  options.method = c.text("method");
  if (c.keyword("classes").empty()) options.classes = static_cast<int>(c.integer("classes"));
  options.d_max = number_or_zero(c, "d_max");
  options.smallest_visible = c.number("smallest_visible");
  options.match_area_fraction = c.boolean("match_area_fraction");
  options.bootstrap = static_cast<int>(c.integer("bootstrap"));
  options.seed = static_cast<std::uint64_t>(c.integer("seed"));
  const std::string border = c.text("border");
  const Observations o = observe(profiles,
                                 border == "all"      ? Border::All
                                 : border == "inside" ? Border::Inside
                                                      : Border::Weights,
                                 options.smallest_visible, number_or_zero(c, "area_fraction"));
  const Unfolding u = unfold(o, kmatrix, options, c.work());
  for (const auto& w : u.warnings) c.warn(w);

  double N_A = 0, N_V = 0, negative = 0;
  int negative_classes = 0;
  for (const ClassFit& f : u.classes) {
    N_A += std::accumulate(f.N_A.begin(), f.N_A.end(), 0.0);
    N_V += std::accumulate(f.N_V.begin(), f.N_V.end(), 0.0);
    negative += f.negative, negative_classes += f.negative_classes;
  }
  c.metric("profiles", static_cast<double>(o.used));
  c.metric("profiles_cut", static_cast<double>(o.cut));
  c.metric("profiles_below_visible", static_cast<double>(o.hidden));
  c.metric("N_A", N_A);
  c.metric("N_V", N_V);
  c.metric("d_max", u.distribution.d_max);
  c.metric("volume_fraction", u.distribution.volume_fraction);
  c.metric("area_fraction", u.area_fraction);
  c.metric("goodness_of_fit", u.distribution.goodness_of_fit);
  c.metric("condition", u.condition);
  if (options.method == "inverse") {
    c.metric("negative_classes", negative_classes);
    c.metric("negative_N_V", negative);
  }
  c.output("table", unfold_table(u));
  c.output("figure", unfold_figure(u));
  c.output("distribution", u.distribution);
}

}  // namespace

NodeType unfold_node() {
  return NodeType("Unfold", 1)
      .doc_(
          "From the profiles in a section to the particles per volume by size class (stereological "
          "unfolding). Colour "
          "classes are unfolded each on its own, in common size classes; several shapes share each size "
          "class by "
          "their probabilities.")
      .source_(
          "Jagnow, Dorsey, Rushmeier 2004, section 3, eq. 4, 8, 12; Saltikov 1967; Lawson and Hanson 1974")
      .input("profiles", "Profiles",
             "What the section shows; observed_area must be known, or area_fraction given here")
      .input("kmatrix", "KMatrix", "Section statistics of the particles' shapes")
      .output("distribution", "SizeDistribution",
              "Particles per mm³ by size class, one entry per shape and colour class")
      .output("figure", "Image",
              "Profile densities with the refit, beside the densities per volume with intervals")
      .output("table", "Table", "The same as numbers, one row per colour class and size class")
      .parameter(
          Parameter::choice("method", "nnls", {"nnls", "inverse"})
              .doc_(
                  "nnls: non-negative least squares, each class weighted by the Poisson error of its count. "
                  "inverse: the paper's K⁻¹, whose negative densities are reported and set to zero."))
      .parameter(
          Parameter::with_keyword(ParameterKind::Int, "classes", "auto")
              .range(1, 200)
              .doc_(
                  "Equal size classes from 0 to d_max; auto: those of the K matrix, or as many as there are "
                  "profiles where these are fewer"))
      .parameter(Parameter::number("smallest_visible", 0)
                     .unit_("mm")
                     .range(0, 1e12)
                     .doc_("Size √(4·A/π) of profile below which the picture shows none: smaller profiles "
                           "are dropped and "
                           "what they would say is left out of the fit, rather than taken as zero"))
      .parameter(
          Parameter::choice("border", "weights", {"weights", "all", "inside"})
              .doc_("weights: those that the border cuts do not count, the others by Miles–Lantuéjoul "
                    "weights. all: "
                    "every profile counts once. inside: uncut profiles count once (biased to small ones)."))
      .parameter(Parameter::integer("bootstrap", 100)
                     .range(0, 100000)
                     .doc_("Repetitions for the 90 % intervals: profiles are drawn again, whole sections "
                           "from 10 sections "
                           "on; 0 for none"))
      .parameter(Parameter::with_keyword(ParameterKind::Number, "d_max", "auto")
                     .unit_("mm")
                     .above(0)
                     .doc_("Size √(4·A_max/π) of the largest particle; auto: the likeliest of 25 sizes from "
                           "the largest "
                           "profile's up to 1.6 times it"))
      .parameter(Parameter::boolean("match_area_fraction", true)
                     .doc_("nnls: adds the identity volume fraction = area fraction as one more equation, "
                           "held to 1 %"))
      .parameter(
          Parameter::with_keyword(ParameterKind::Number, "area_fraction", "auto")
              .above(0)
              .range(0, 1)
              .doc_(
                  "Share of the section covered by profiles; auto: as the profiles say. Where their observed "
                  "area is unknown, it follows from this."))
      .parameter(Parameter::integer("seed", 1).range(0, 9007199254740991).doc_("Of the bootstrap"))
      .compute_(compute);
}

}  // namespace terrazzo
