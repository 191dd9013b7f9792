#include "nodes/sizes/shape_families/score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/sizes/shape_families/likeness.h"
#include "nodes/sizes/shape_families/sections.h"
#include "nodes/sizes/unfolding/em.h"
#include "nodes/sizes/unfolding/unfold.h"
#include "runtime/random.h"

namespace terrazzo::shape_families {
namespace {

using Eigen::VectorXd;

constexpr double kAnySize = 0.01, kAnyOutline = 0.05;  // probability of profiles that follow no family
// Least bandwidth of each feature: the scatter that is left of pixels after the blur.
constexpr Features kLeastBandwidth = {0.01, 0.02, 1.0};
constexpr double kPlausible = 2;  // standard errors

// A profile that takes part, in the order of Observations.
struct Predicted {
  double size = 0, weight = 0;
  int fold = 0;
  std::optional<MeasuredProfile> outline;
};

// Densities per mm of particle size, constant within bins.
struct SizeDensity {
  std::vector<double> edges;
  VectorXd density;

  double mean() const {  // size, by number
    double sum = 0, sizes = 0;
    for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
      const double n = density[k] * (edges[k + 1] - edges[k]);
      sum += n;
      sizes += n * (edges[k] + edges[k + 1]) / 2;
    }
    return sum > 0 ? sizes / sum : 0;
  }

  double at(double size) const {
    const auto k = std::upper_bound(edges.begin(), edges.end(), size) - edges.begin();
    if (k == 0 || k == static_cast<std::ptrdiff_t>(edges.size())) return 0;
    return density[k - 1];
  }
};

double normal(double x, double mean, double deviation) {
  const double z = (x - mean) / deviation;
  return std::exp(-0.5 * z * z) / (deviation * std::sqrt(2 * std::numbers::pi));
}

struct Spread {
  Features mean{}, deviation{};
};

Spread spread_of(const std::vector<Features>& values) {
  Spread s;
  const double n = values.size();
  for (std::size_t k = 0; k < kFeatures; ++k) {
    double sum = 0, squares = 0;
    for (const Features& v : values) sum += v[k];
    s.mean[k] = sum / n;
    for (const Features& v : values) squares += (v[k] - s.mean[k]) * (v[k] - s.mean[k]);
    s.deviation[k] = std::sqrt(squares / n);
  }
  return s;
}

// Density of outlines that follow no family: a normal one, twice as wide as all profiles together.
double any_outline(const Features& f, const Spread& all) {
  double p = 1;
  for (std::size_t k = 0; k < kFeatures; ++k)
    p *= normal(f[k], all.mean[k], 2 * std::max(all.deviation[k], kLeastBandwidth[k]));
  return p;
}

// The kernel density of a family's outlines.
class OutlineDensity {
 public:
  OutlineDensity(const FamilySections& sections, const Shapes& shapes)
      : sections_(sections), likeness_(shapes) {
    // Silverman's rule for the sections of about a third of all relative sizes, which matter for one profile.
    const double n = std::max<double>(1, static_cast<double>(sections.ratio.size()) / 3);
    const double d = kFeatures, rule = std::pow(4 / ((d + 2) * n), 1 / (d + 4));
    for (std::size_t l = 0; l < kBlur.size(); ++l) {
      const Spread s = spread_of(sections.features[l]);
      for (std::size_t k = 0; k < kFeatures; ++k)
        bandwidth_[l][k] = std::hypot(rule * s.deviation[k], kLeastBandwidth[k]);
    }
  }

  // Of a profile's outline given its size; 0 if no particle of the density shows such a size.
  double at(double size, const MeasuredProfile& p, const SizeDensity& particles) const {
    const auto& features = sections_.features[p.level];
    const auto& h = bandwidth_[p.level];
    const double mean = particles.mean();
    double sum = 0, total = 0;
    for (std::size_t m = 0; m < features.size(); ++m) {
      const double r = sections_.ratio[m];
      double w = particles.at(size / r) * size / (r * r);
      if (!(w > 0)) continue;
      w *= likeness_(sections_.natural[m], size / (r * mean));
      total += w;
      double exponent = 0;
      for (std::size_t k = 0; k < kFeatures; ++k) {
        const double z = (p.features[k] - features[m][k]) / h[k];
        exponent += z * z;
      }
      if (exponent < 80) sum += w * std::exp(-0.5 * exponent);
    }
    if (!(total > 0)) return 0;
    double volume = std::pow(2 * std::numbers::pi, 0.5 * kFeatures);
    for (const double b : h) volume *= b;
    return sum / (total * volume);
  }

 private:
  const FamilySections& sections_;
  Likeness likeness_;
  std::array<Features, kBlur.size()> bandwidth_{};
};

// Log predictive densities of each profile.
struct Predictions {
  std::vector<double> size, outline;  // outline: 0 where none was measured
};

unfolding::Observation without(const unfolding::Observation& all, const std::vector<Predicted>& profiles,
                               int fold) {
  unfolding::Observation out;
  out.area_fraction = all.area_fraction;
  for (std::size_t i = 0; i < profiles.size(); ++i)
    if (profiles[i].fold != fold)
      out.size.push_back(all.size[i]), out.weight.push_back(all.weight[i]),
          out.section.push_back(all.section[i]);
  return out;
}

Predictions predict(const Family& family, const unfolding::UnfoldResult& full,
                    const std::vector<Predicted>& profiles, const Spread& all, const ScoreOptions& s,
                    const Work& work) {
  const unfolding::Observation& q = full.observations.classes.front();
  const unfolding::EmModel model = unfolding::make_em_model(*family.kmatrix, full.model);
  const FamilySections sections = family_sections(*family.shapes, s.sections, s.seed, work.part(0, 0.3));
  const OutlineDensity outlines(sections, *family.shapes);
  Predictions out{std::vector<double>(profiles.size()), std::vector<double>(profiles.size())};
  const double range = model.profiles.back() - model.profiles.front();
  for (int fold = 0; fold < s.folds; ++fold) {
    const auto at = [&](double f) { return 0.3 + 0.7 * (fold + f) / s.folds; };
    const double kept = 1 - 1.0 / s.folds;
    const unfolding::EmFit fit =
        unfolding::fit_em(model, without(q, profiles, fold), full.observations.area * kept,
                          unfolding::kFractionError, work.part(at(0), at(0.6)));
    const VectorXd seen = model.fine * fit.density;
    SizeDensity particles{model.sizes, fit.density};
    for (Eigen::Index j = 0; j < fit.density.size(); ++j)
      particles.density[j] /= model.sizes[j + 1] - model.sizes[j];
    work.part(at(0.6), at(1)).parallel(profiles.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Predicted& p = profiles[i];
        if (p.fold != fold) continue;
        work.check();
        const auto k = std::upper_bound(model.profiles.begin(), model.profiles.end(), p.size) -
                       model.profiles.begin() - 1;
        const auto bin = std::clamp<std::ptrdiff_t>(k, 0, seen.size() - 1);
        const double width = model.profiles[bin + 1] - model.profiles[bin];
        out.size[i] = std::log((1 - kAnySize) * seen[bin] / (seen.sum() * width) + kAnySize / range);
        if (p.outline)
          out.outline[i] = std::log((1 - kAnyOutline) * outlines.at(p.size, *p.outline, particles) +
                                    kAnyOutline * any_outline(p.outline->features, all));
      }
    });
  }
  return out;
}

// Folds of equal size, in random order.
void deal_folds(std::vector<Predicted>& profiles, int folds, std::uint64_t seed) {
  std::vector<std::size_t> order(profiles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random random(seed, 0xfa01);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  for (std::size_t i = 0; i < order.size(); ++i)
    profiles[order[i]].fold = i % static_cast<std::size_t>(folds);
}

void add_densities(FamilyScore& out, const unfolding::UnfoldResult& r) {
  const auto& d = r.distribution;
  double sizes = 0;
  for (const auto& e : d.shapes)
    for (std::size_t k = 0; k < e.N_V.size(); ++k) {
      out.N_V += e.N_V[k];
      out.low += e.low[k];
      out.high += e.high[k];
      sizes += e.N_V[k] * (d.class_edges[k] + d.class_edges[k + 1]) / 2;
    }
  out.mean_size = out.N_V > 0 ? sizes / out.N_V : 0;
  out.goodness_of_fit = d.goodness_of_fit;
}

void compare(Scores& scores, const std::vector<Predictions>& predictions,
             const std::vector<Predicted>& profiles) {
  double weights = 0;
  for (const Predicted& p : profiles) weights += p.weight;
  const auto mean = [&](auto&& value) {
    double sum = 0;
    for (std::size_t i = 0; i < profiles.size(); ++i) sum += profiles[i].weight * value(i);
    return sum / weights;
  };
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < predictions.size(); ++f) {
    FamilyScore& s = scores.families[f];
    s.sizes = mean([&](std::size_t i) { return predictions[f].size[i]; });
    s.outlines = mean([&](std::size_t i) { return predictions[f].outline[i]; });
    if (s.sizes + s.outlines > best) {
      best = s.sizes + s.outlines;
      scores.best = f;
    }
  }
  for (std::size_t f = 0; f < predictions.size(); ++f) {
    FamilyScore& s = scores.families[f];
    const auto difference = [&](std::size_t i) {
      const Predictions &a = predictions[f], &b = predictions[scores.best];
      return (a.size[i] - b.size[i]) + (a.outline[i] - b.outline[i]);
    };
    s.behind = mean(difference);
    double squares = 0;
    for (std::size_t i = 0; i < profiles.size(); ++i)
      squares += std::pow(profiles[i].weight * (difference(i) - s.behind), 2);
    s.error = std::sqrt(squares) / weights;
    s.plausible = f == scores.best || s.behind >= -kPlausible * s.error;
  }
}

}  // namespace

Scores score_families(const Profiles& profiles, const std::vector<Family>& families, const ScoreOptions& s,
                      const Work& work) {
  for (const Family& f : families)
    if (f.shapes->shapes.size() != f.kmatrix->shapes.size())
      throw Error("wrong-count",
                  fmt::format("the family {} has {} shapes, but its K matrix has {}", f.name,
                              f.shapes->shapes.size(), f.kmatrix->shapes.size()),
                  "connect the K matrices of these shapes, in the same order");
  if (profiles.view == View::Surface)
    throw Error(
        "not-sections", "the profiles are silhouettes of a surface, but families are compared by sections",
        "connect profiles of a section, or set view of Segment to section if the photograph shows one");
  Profiles pooled = profiles;
  for (Profile& p : pooled.profiles) p.cls = 0;
  pooled.classes = 1;
  unfolding::UnfoldOptions options;
  options.smallest_visible = s.smallest_visible;
  options.bootstrap = s.bootstrap;
  options.seed = s.seed;

  Scores out;
  std::vector<Predictions> predictions;
  std::vector<Predicted> used;
  Spread all;
  const double n = families.size();
  for (std::size_t f = 0; f < families.size(); ++f) {
    const auto at = [&](double t) { return (f + t) / n; };
    const unfolding::UnfoldResult full =
        unfolding::unfold(pooled, *families[f].kmatrix, options, work.part(at(0), at(0.4)));
    const unfolding::Observation& q = full.observations.classes.front();
    if (f == 0) {
      for (std::size_t i = 0; i < q.size.size(); ++i)
        used.push_back({q.size[i], q.weight[i], 0, measured(pooled.profiles[q.profile[i]])});
      if (used.size() < static_cast<std::size_t>(2 * s.folds))
        throw Error("too-few-profiles",
                    fmt::format("{} folds need at least {} profiles; there are {}", s.folds, 2 * s.folds,
                                used.size()),
                    "use fewer folds, or a larger photograph");
      deal_folds(used, s.folds, s.seed);
      std::vector<Features> values;
      for (const Predicted& p : used)
        if (p.outline) values.push_back(p.outline->features);
      if (!values.empty()) all = spread_of(values);
      out.profiles = used.size();
      out.outlines = values.size();
      out.relative = full.observations.relative;
    }
    add_densities(out.families.emplace_back(), full);
    predictions.push_back(predict(families[f], full, used, all, s, work.part(at(0.4), at(1))));
  }
  compare(out, predictions, used);
  return out;
}

}  // namespace terrazzo::shape_families
