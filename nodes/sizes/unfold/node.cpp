#include <fmt/format.h>

#include "graph/node_type.h"
#include "nodes/common/plot/plot.h"
#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/sizes/unfold/limit.h"
#include "nodes/sizes/unfold/summary.h"
#include "nodes/sizes/unfolding/unfold.h"
#include "runtime/context.h"

namespace terrazzo::unfold {
namespace {
using namespace unfolding;

// Relative effect of the smallest profiles on the density of larger particles that is reported.
constexpr double kLimitEffect = 0.25;
// χ² per degree of freedom from which shapes or limits are wrong, whatever the counting noise.
constexpr double kPoorFit = 10;
// Volume fraction above which stones that lie loosely do not pack.
constexpr double kDensestBed = 0.7;
// Volume fraction from which rigid particles cannot be packed, and sphericity of bodies that are rounder than
// any that fill space: Kelvin's cell has 0.80, the cells of random tessellations less.
constexpr double kNearlyFull = 0.9, kRounderThanCells = 0.85;

// What follows the name of a density: its unit, or that only ratios of densities have a meaning.
const char* unit_of_areas(const UnfoldResult& r) { return r.observations.relative ? "relative" : "mm⁻²"; }
const char* unit_of_volumes(const UnfoldResult& r) { return r.observations.relative ? "relative" : "mm⁻³"; }

Table table_of(const UnfoldResult& r, const SizeSummary& summary, double equivalent) {
  const auto per_area = [&](const char* name) { return fmt::format("{} {}", name, unit_of_areas(r)); };
  const auto per_volume = [&](const char* name) { return fmt::format("{} {}", name, unit_of_volumes(r)); };
  Table t;
  t.columns = {"class",
               "from mm",
               "to mm",
               "equivalent from mm",
               "equivalent to mm",
               per_area("N_A observed"),
               per_area("N_A refitted"),
               per_volume("N_V"),
               per_volume("N_V low"),
               per_volume("N_V high"),
               "volume share",
               "volume passing"};
  for (std::size_t c = 0; c < r.fits.size(); ++c)
    for (int j = 0; j < r.model.visible(); ++j) {
      const std::size_t k = r.model.first + j;
      double low = 0, high = 0;
      for (const auto& e : r.distribution.shapes)
        if (e.cls == static_cast<int>(c)) {
          low += e.low[k];
          high += e.high[k];
        }
      auto& row = t.rows.emplace_back();
      for (const double v :
           {static_cast<double>(c), r.distribution.class_edges[k], r.distribution.class_edges[k + 1],
            equivalent * r.distribution.class_edges[k], equivalent * r.distribution.class_edges[k + 1],
            r.fits[c].observed[j], r.fits[c].refitted[j], r.fits[c].density[j], low, high,
            summary.volume_share[k], summary.volume_passing[k]})
        row.emplace_back(v);
    }
  return t;
}

Image figure_of(const UnfoldResult& r, const SizeSummary& summary) {
  Plot areas, volumes, sieve;
  areas.title = "Profiles per area";
  areas.x_label = "size of the profile, mm";
  areas.y_label = fmt::format("N_A, {}", unit_of_areas(r));
  volumes.title = "Particles per volume";
  volumes.x_label = "size of the particle, mm";
  volumes.y_label = fmt::format("N_V, {}", unit_of_volumes(r));
  PlotSeries observed{PlotSeries::Kind::Bars, "observed", {}, {}, {}, {}, 0};
  PlotSeries refitted{PlotSeries::Kind::Bars, "refitted", {}, {}, {}, {}, 1};
  PlotSeries density{PlotSeries::Kind::Bars, "", {}, {}, {}, {}, 2};
  for (int j = 0; j < r.model.visible(); ++j) {
    const std::size_t k = r.model.first + j;
    const double x = (r.model.edges[k] + r.model.edges[k + 1]) / 2;
    double a = 0, b = 0, v = 0, low = 0, high = 0;
    for (const auto& f : r.fits) {
      a += f.observed[j];
      b += f.refitted[j];
      v += f.density[j];
    }
    for (const auto& e : r.distribution.shapes) {
      low += e.low[k];
      high += e.high[k];
    }
    observed.x.push_back(x);
    observed.y.push_back(a);
    refitted.x.push_back(x);
    refitted.y.push_back(b);
    density.x.push_back(x);
    density.y.push_back(v);
    density.low.push_back(low);
    density.high.push_back(high);
  }
  areas.series = {observed, refitted};
  volumes.series = {density};
  sieve.title = "Sieve curve";
  sieve.x_label = "size of the particle, mm";
  sieve.y_label = "share of volume that passes";
  PlotSeries passing{PlotSeries::Kind::Line, "", {}, {}, {}, {}, 2};
  for (std::size_t k = r.model.first; k <= summary.volume_passing.size(); ++k) {
    passing.x.push_back(r.model.edges[k]);
    passing.y.push_back(k > 0 ? summary.volume_passing[k - 1] : 0);
  }
  sieve.series = {passing};
  return draw({areas, volumes, sieve}, 3);
}

// Warns of shapes that cannot be those of the particles, as far as the sizes tell.
void warn_of_shapes(Context& c, const UnfoldResult& r, const KMatrix& kmatrix) {
  const double fit = r.distribution.goodness_of_fit;
  if (fit > kPoorFit)
    c.warn(fmt::format(
        "the refitted profiles differ from the observed ones far beyond chance: goodness_of_fit is "
        "{:.3g}, and 1 is expected; check d_max, smallest_visible and the shapes of the K matrix",
        fit));
  const double fraction = r.distribution.volume_fraction;
  if (!r.observations.relative && fraction > kNearlyFull && sphericity(kmatrix) > kRounderThanCells)
    c.warn(
        fmt::format("the particles fill {:.3g} of the volume, which bodies as round as those of the K matrix "
                    "cannot; grains that fill space are cells, and another number of them has the same "
                    "profiles: connect the K matrix of cells that Tessellate makes, and compare both with "
                    "ShapeFamilies",
                    fraction));
}

UnfoldOptions options_of(const Context& c) {
  UnfoldOptions o;
  o.method = c.choice<unfolding::Method>("method");
  if (const auto v = c.optional_integer("classes")) o.classes = *v;
  if (const auto v = c.optional_number("smallest_visible")) o.smallest_visible = *v;
  o.border = c.choice<Border>("border");
  if (const auto v = c.optional_number("d_max")) o.d_max = *v;
  o.area_fraction = c.number("area_fraction");
  o.types = c.choice<Types>("types");
  o.bootstrap = c.integer("bootstrap");
  o.seed = c.seed();
  return o;
}

// Tells how much the smallest profiles matter.
void report_limit(Context& c, const Profiles& profiles, const KMatrix& kmatrix, const UnfoldOptions& o,
                  const UnfoldResult& r) {
  const auto limit = limit_sensitivity(profiles, kmatrix, o, r, c.work().part(0.9, 1));
  if (!limit) return;
  c.metric("smallest_class_share", limit->share);
  c.metric("smallest_class_effect", limit->change);
  if (std::abs(limit->change) > kLimitEffect)
    c.warn(
        fmt::format("without the profiles of the smallest class, below {:.3g} mm, N_V of all larger "
                    "particles would be {:.0f} % {}: the photograph may miss small profiles or show "
                    "false ones; compare with smallest_visible: {:.3g}",
                    r.model.profile_edges[1], 100 * std::abs(limit->change),
                    limit->change > 0 ? "higher" : "lower", r.model.profile_edges[1]));
}

void compute(Context& c) {
  const UnfoldOptions o = options_of(c);
  const auto& profiles = c.input<Profiles>("profiles");
  const auto& kmatrix = c.input<KMatrix>("kmatrix");
  UnfoldResult r = unfolding::unfold(profiles, kmatrix, o, c.work().part(0, 0.9));
  double fraction = 0, negative = 0, freedom = 0, jumps = 0;
  for (const auto& q : r.observations.classes) fraction += q.area_fraction;
  for (const auto& f : r.fits) {
    negative = std::max(negative, f.negative);
    freedom += f.freedom;
    jumps += f.jumps;
  }
  if (negative > 0)
    c.warn(fmt::format(
        "{:.0f} % of the densities were negative and were set to zero; method: em keeps densities positive",
        100 * negative));
  const bool surface = profiles.view == View::Surface;
  if (surface && !r.observations.relative && r.distribution.volume_fraction > kDensestBed)
    c.warn(
        fmt::format("the stones would fill {:.3g} of the volume, more than loose stones can: outlines may "
                    "show several stones as one; look at the labels, or set view of Segment to section if "
                    "the photograph shows a cut",
                    r.distribution.volume_fraction));
  if (!surface && !r.observations.relative &&
      std::abs(r.distribution.volume_fraction - fraction) > 0.1 * fraction)
    c.warn(fmt::format(
        "the estimated particles fill {:.3g} of the volume, but the profiles cover {:.3g} of the section",
        r.distribution.volume_fraction, fraction));
  const int asked = kmatrix.classes;
  if (o.classes == 0 && r.model.equal < asked)
    c.warn(fmt::format(
        "{} profiles support only {} size classes, not the {} of the K matrix; set classes to override this",
        r.observations.used, r.model.equal, asked));
  if (r.observations.relative)
    c.warn(
        "the observed area is unknown, so densities are relative and sum to 1; set observed_area where the "
        "profiles are loaded, or area_fraction here");
  if (static_cast<int>(r.observations.used) < r.model.visible())
    c.warn(fmt::format("only {} profiles for {} classes: use fewer classes or a larger photograph",
                       r.observations.used, r.model.visible()));
  if (!r.observations.relative) report_limit(c, profiles, kmatrix, o, r);
  if (!surface) warn_of_shapes(c, r, kmatrix);
  c.metric("classes", r.model.classes());
  c.metric("freedom", freedom);
  if (o.method == unfolding::Method::Em) c.metric("jumps", jumps);
  c.metric("profiles_used", r.observations.used);
  c.metric("area_fraction", fraction);
  c.metric("volume_fraction", r.distribution.volume_fraction);
  c.metric("d_max", r.distribution.d_max);
  c.metric("goodness_of_fit", r.distribution.goodness_of_fit);
  c.metric("condition", r.condition);
  c.metric("negative", negative);
  const SizeSummary summary = summarize(r.distribution);
  if (!r.observations.relative) c.metric("N_V", summary.N_V);
  c.metric("mean_size", summary.mean);
  c.metric("median_size", summary.median);
  c.metric("geometric_mean", summary.geometric_mean);
  c.metric("geometric_sd", summary.geometric_sd);
  c.metric("volume_d10", summary.d10);
  c.metric("volume_d50", summary.d50);
  c.metric("volume_d90", summary.d90);
  c.output("table", table_of(r, summary, equivalent_diameter(c.input<KMatrix>("kmatrix"))));
  c.output("figure", figure_of(r, summary));
  c.output("distribution", std::move(r.distribution));
}

}  // namespace
}  // namespace terrazzo::unfold

namespace terrazzo {

NodeType unfold_node() {
  using namespace unfold;
  return NodeType("Unfold", 15)
      .doc_(
          "Estimates how many particles of each size a volume holds from the sizes of the profiles in its "
          "sections, or of the silhouettes that a surface shows. Each color class is unfolded separately; "
          "shapes are mixed by their probabilities.")
      .source_(
          "Jagnow, Dorsey, Rushmeier 2004, section 3, eq. 8 and 12; Silverman et al. 1990 (em); Kellerhals, "
          "Bray 1971 (surfaces)")
      .input("profiles", "Profiles", "Profiles observed in the sections, with the observed area")
      .input("kmatrix", "KMatrix", "Section statistics of the particle shapes")
      .output("distribution", "SizeDistribution",
              "Particles per mm³ by size class, for each color class and shape")
      .output("table", "Table",
              "N_A observed and refitted, and N_V with its interval, by size class; over all colors, the "
              "volume share and the cumulative share (the sieve curve)")
      .output("figure", "Image", "Bar charts of profiles and particles, and the sieve curve")
      .parameter(Parameter::choice("method", "em", {"em", "nnls", "inverse"})
                     .doc_("em: maximum likelihood of the counts; the counts choose how smooth the density "
                           "is. nnls: nonnegative least squares, each class weighted by its counting error. "
                           "Both hold the volume fraction to the profiles' area fraction. inverse: the "
                           "paper's K⁻¹; negative densities are reported and set to zero."))
      .parameter(Parameter::optional_integer("classes", "auto")
                     .range(1, 200)
                     .doc_("Number of equal size classes from 0 to d_max. auto: as many as the K matrix has, "
                           "but at most 2·n^⅓ for n profiles; em then divides the smallest visible class "
                           "into parts of at most a factor of two, as far as its profiles suffice."))
      .parameter(
          Parameter::optional_number("smallest_visible", "auto")
              .unit_("mm")
              .range(0, 1e9)
              .doc_("Size of the smallest profile that the photograph can show. Smaller profiles are "
                    "treated as unobserved, not as nonexistent. auto: the smallest profile observed, or "
                    "1.3 times as much for loose stones."))
      .parameter(Parameter::choice("border", "weights", {"weights", "inside", "all"})
                     .doc_("weights: profiles cut by the border are left out and the others weighted to "
                           "compensate (Miles and Lantuéjoul). inside: cut profiles are left out. all: every "
                           "profile counts once, cut ones with their visible part."))
      .parameter(Parameter::optional_number("d_max", "auto")
                     .unit_("mm")
                     .range(1e-9, 1e9)
                     .doc_("Size of the largest particle. auto: the smallest that explains the profiles as "
                           "well as any does, within a standard error."))
      .parameter(Parameter::number("area_fraction", 0)
                     .range(0, 1)
                     .doc_("Area fraction of the section that profiles cover. Used instead of the fraction "
                           "in the profiles. 0: use that of the profiles, if known."))
      .parameter(
          Parameter::choice("types", "mixed", {"mixed", "by_class"})
              .doc_("Shapes of the particles of a color class. mixed: the shapes of the class, such as "
                    "ShapeEstimate makes with class: each, and all shapes without a class, by their "
                    "probabilities (eq. 10 to 12). by_class: class 0 has the first shape, class 1 the "
                    "second, and so on (eq. 9)."))
      .parameter(Parameter::integer("bootstrap", 100)
                     .range(0, 100000)
                     .doc_("Number of bootstrap repetitions for the 90 % intervals. They resample profiles, "
                           "or whole sections if there are at least ten; em also samples the bias of "
                           "smoothing. 0: no intervals."))
      .parameter(Parameter::seed().doc_("Random seed of the bootstrap"))
      .compute_(compute);
}

}  // namespace terrazzo
