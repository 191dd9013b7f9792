#include "nodes/sizes/mix_distributions/mix_distributions.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/indices.h"

namespace terrazzo::mix_distributions {
namespace {

void check(const SizeDistribution& d, const Shapes& shapes, std::size_t number) {
  const auto bad = [&](const std::string& what) {
    throw Error("bad-distribution", fmt::format("distribution {} {}", number, what),
                "connect distributions from Distribution or Unfold, each with its own shapes");
  };
  if (d.classes() == 0 || d.shapes.empty()) bad("is empty");
  for (std::size_t k = 0; k + 1 < d.class_edges.size(); ++k)
    if (!(d.class_edges[k] >= 0 && d.class_edges[k] < d.class_edges[k + 1]) ||
        !std::isfinite(d.class_edges[k + 1]))
      bad("has class edges that do not increase");
  double sum = 0;
  for (const auto& e : d.shapes) {
    if (e.N_V.size() != d.classes() || e.low.size() != d.classes() || e.high.size() != d.classes())
      bad("has an entry with another number of classes");
    if (e.shape < -1 || e.shape >= count_of(shapes.shapes))
      bad(fmt::format("refers to shape {} of {}", e.shape, shapes.shapes.size()));
    if (e.cls < 0) bad("has a negative class");
    for (const double v : e.N_V) {
      if (!(v >= 0) || !std::isfinite(v)) bad("has a density that is negative or not finite");
      sum += v;
    }
  }
  if (sum > 0 && !(d.volume_fraction > 0))
    throw Error("relative-densities",
                fmt::format("the densities of distribution {} are relative, so they cannot be added", number),
                "unfold profiles with a known area");
}

// All edges; those that differ by rounding only are one.
std::vector<double> all_edges(const std::vector<const SizeDistribution*>& distributions) {
  std::vector<double> all, out;
  for (const auto* d : distributions) all.insert(all.end(), d->class_edges.begin(), d->class_edges.end());
  std::sort(all.begin(), all.end());
  for (const double edge : all)
    if (out.empty() || edge > out.back() + 1e-9 * all.back()) out.push_back(edge);
  return out;
}

// Densities by the classes `from` as densities by the finer classes `to`.
std::vector<double> divided(const std::vector<double>& density, const std::vector<double>& from,
                            const std::vector<double>& to, double share) {
  std::vector<double> out(to.size() - 1, 0);
  for (std::size_t k = 0; k < density.size(); ++k) {
    const double width = from[k + 1] - from[k];
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double inside = std::min(to[i + 1], from[k + 1]) - std::max(to[i], from[k]);
      if (inside > 1e-6 * width) out[i] += share * density[k] * inside / width;
    }
  }
  return out;
}

}  // namespace

Mixture mix(const std::vector<const SizeDistribution*>& distributions,
            const std::vector<const Shapes*>& sets) {
  if (distributions.size() != sets.size())
    throw Error(
        "wrong-count",
        fmt::format("there are {} distributions, but {} sets of shapes", distributions.size(), sets.size()),
        "connect one set of shapes for each distribution, in the same order");
  Mixture out;
  SizeDistribution& all = out.distribution;
  for (std::size_t i = 0; i < sets.size(); ++i) check(*distributions[i], *sets[i], i + 1);
  all.class_edges = all_edges(distributions);
  int first_class = 0;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const SizeDistribution& d = *distributions[i];
    Shapes set = *sets[i];
    normalize_probabilities(set);
    int classes = 1;
    double number = 0;
    for (const auto& e : d.shapes) {
      classes = std::max(classes, e.cls + 1);
      for (const double v : e.N_V) number += v;
    }
    const int first_shape = out.shapes.shapes.size();
    const auto add = [&](const SizeDistribution::Entry& e, int shape, double share) {
      SizeDistribution::Entry& own = all.shapes.emplace_back();
      own.shape = first_shape + shape;
      own.cls = first_class + e.cls;
      own.N_V = divided(e.N_V, d.class_edges, all.class_edges, share);
      own.low = divided(e.low, d.class_edges, all.class_edges, share);
      own.high = divided(e.high, d.class_edges, all.class_edges, share);
    };
    for (const auto& e : d.shapes) {
      if (e.shape >= 0) add(e, e.shape, 1);
      for (std::size_t s = 0; e.shape < 0 && s < set.shapes.size(); ++s)
        if (set.shapes[s].probability > 0) add(e, static_cast<int>(s), set.shapes[s].probability);
    }
    for (Shape& s : set.shapes) {
      if (s.cls < 0 && classes > 1)
        throw Error("mixed-classes",
                    fmt::format("distribution {} has {} classes, but its shape '{}' is for any of them",
                                i + 1, classes, s.name),
                    "estimate shapes with class: each");
      s.cls = first_class + std::max(0, s.cls);
      s.probability *= number;
      out.shapes.shapes.push_back(std::move(s));
    }
    first_class += classes;
    all.volume_fraction += d.volume_fraction;
    all.d_max = std::max(all.d_max, d.d_max);
  }
  if (all.volume_fraction > 1)
    throw Error("too-dense",
                fmt::format("the volume fractions add up to {:.4g}, which is more than the volume",
                            all.volume_fraction),
                "lower the volume fractions");
  normalize_probabilities(out.shapes);
  return out;
}

}  // namespace terrazzo::mix_distributions
