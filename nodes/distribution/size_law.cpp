#include "nodes/distribution/size_law.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/size_kernel.h"

namespace terrazzo {
namespace {

// The exponent of a Weibull law from its coefficient of variation, which falls steadily with it: by
// bisection.
double weibull_exponent(double variation) {
  const auto squared = [](double k) {
    return std::exp(std::lgamma(1 + 2 / k) - 2 * std::lgamma(1 + 1 / k)) - 1;
  };
  double lo = 0.1, hi = 1000;
  if (!(squared(lo) > variation * variation) || !(squared(hi) < variation * variation))
    throw Error("bad-law", fmt::format("no Rosin–Rammler law has an sd of {:.4g} times its mean", variation),
                "choose an sd between 0.002 and 100 times the mean")
        .parameter("sd");
  for (int i = 0; i < 200; ++i) (squared((lo + hi) / 2) > variation * variation ? lo : hi) = (lo + hi) / 2;
  return (lo + hi) / 2;
}

double normal_cumulative(double x) { return std::erfc(-x / std::numbers::sqrt2) / 2; }

void check_edges(const std::vector<double>& edges) {
  const auto bad = [](const std::string& what) {
    throw Error("bad-classes", what, "give rising sizes in mm, one more than there are classes")
        .parameter("class_edges");
  };
  if (edges.size() < 2)
    bad(fmt::format("{} class edge{} make no class", edges.size(), edges.size() == 1 ? "" : "s"));
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!std::isfinite(edges[i]) || edges[i] < 0) bad(fmt::format("class edge {} is {}", i, edges[i]));
    if (i > 0 && !(edges[i] > edges[i - 1]))
      bad(fmt::format("class edge {} ({}) does not exceed the one before ({})", i, edges[i], edges[i - 1]));
  }
}

// Mean volume of a particle of size 1 mm, mm³.
double unit_volume(const Shapes* shapes) {
  if (!shapes) return std::numbers::pi / 6;
  double sum = 0, total = 0;
  for (const Shape& s : shapes->shapes) {
    if (!(s.max_section_area > 0) || !(s.volume > 0) || !(s.probability >= 0))
      throw Error("unmeasured-shape",
                  fmt::format("\"{}\" has no volume, largest section or probability", s.name),
                  "make shapes with nodes that measure them");
    sum += s.probability * s.volume / std::pow(s.size(), 3);
    total += s.probability;
  }
  if (!(total > 0))
    throw Error("bad-probabilities", "the probabilities of the shapes are all zero", "make one positive");
  return sum / total;
}

}  // namespace

SizeLaw::SizeLaw(const std::string& kind, double mean, double sd, double min, double max)
    : kind_(kind), mean_(mean), sd_(sd), min_(min), max_(max) {
  const auto bad = [](const std::string& what, const std::string& hint, const char* parameter) {
    throw Error("bad-law", what, hint).parameter(parameter);
  };
  if (!(min >= 0) || !std::isfinite(min))
    bad(fmt::format("the smallest size is {}", min), "give it in mm", "min");
  if (!std::isfinite(max)) bad(fmt::format("the largest size is {}", max), "give it in mm", "max");
  if (kind_ == "uniform") {
    if (!(max_ > min_))
      bad(fmt::format("a uniform law needs a largest size above the smallest, {:.4g} mm", min_), "set max",
          "max");
    return;
  }
  if (!(mean > 0) || !std::isfinite(mean))
    bad(fmt::format("the mean size is {}", mean), "make it positive", "mean");
  if (!(sd > 0) || !std::isfinite(sd))
    bad(fmt::format("the standard deviation is {}", sd), "make it positive, or use kind: uniform", "sd");
  if (kind_ == "lognormal") {
    const double variance = std::log1p(sd * sd / (mean * mean));
    a_ = std::log(mean) - variance / 2, b_ = std::sqrt(variance);
  } else if (kind_ == "normal") {
    a_ = mean, b_ = sd;
  } else {
    b_ = weibull_exponent(sd / mean);
    a_ = mean / std::exp(std::lgamma(1 + 1 / b_));
  }
  if (!(max_ > 0)) max_ = upper_size(1e-3);
  if (!(max_ > min_))
    bad(fmt::format("the largest size, {:.4g} mm, is not above the smallest, {:.4g} mm", max_, min_),
        "raise max or lower min", "max");
  if (!(cumulative(max_) - cumulative(min_) > 1e-9))
    bad(fmt::format("nothing of the law (mean {:.4g}, sd {:.4g} mm) lies between {:.4g} and {:.4g} mm", mean,
                    sd, min_, max_),
        "widen min and max", "max");
}

double SizeLaw::cumulative(double s) const {
  if (kind_ == "uniform") return std::clamp((s - min_) / (max_ - min_), 0.0, 1.0);
  if (kind_ == "normal") return normal_cumulative((s - a_) / b_);
  if (s <= 0) return 0;
  if (kind_ == "lognormal") return normal_cumulative((std::log(s) - a_) / b_);
  return -std::expm1(-std::pow(s / a_, b_));
}

double SizeLaw::upper_size(double share) const {
  double lo = 0, hi = mean_;
  while (1 - cumulative(hi) > share) hi *= 2;
  for (int i = 0; i < 200; ++i) (1 - cumulative((lo + hi) / 2) > share ? lo : hi) = (lo + hi) / 2;
  return hi;
}

double SizeLaw::share(double lo, double hi) const {
  lo = std::clamp(lo, min_, max_), hi = std::clamp(hi, min_, max_);
  return (cumulative(hi) - cumulative(lo)) / (cumulative(max_) - cumulative(min_));
}

SizeDistribution make_distribution(const DistributionOptions& o, const Shapes* shapes) {
  const bool written = o.kind == "classes";
  if (o.volume_fraction > 0 && o.number_density > 0)
    throw Error("two-amounts", "both volume_fraction and number_density are given", "keep one of them")
        .parameter("number_density");
  if (!written && !(o.volume_fraction > 0) && !(o.number_density > 0))
    throw Error("no-amount", "a law tells the sizes but not how many particles there are",
                "set volume_fraction or number_density")
        .parameter("volume_fraction");
  if (!written && !o.N_V.empty())
    throw Error("bad-classes", fmt::format("N_V is given, but kind {} computes it", o.kind),
                "use kind: classes")
        .parameter("N_V");

  SizeDistribution d;
  SizeDistribution::Entry entry;
  entry.shape = -1;
  if (written) {
    check_edges(d.class_edges = o.class_edges);
    if (o.N_V.size() + 1 != d.class_edges.size())
      throw Error("bad-classes",
                  fmt::format("{} class edges make {} classes, but N_V has {} numbers", d.class_edges.size(),
                              d.class_edges.size() - 1, o.N_V.size()),
                  "give one N_V per class")
          .parameter("N_V");
    entry.N_V = o.N_V;
    for (std::size_t j = 0; j < entry.N_V.size(); ++j)
      if (!(entry.N_V[j] >= 0) || !std::isfinite(entry.N_V[j]))
        throw Error("bad-classes", fmt::format("N_V of class {} is {}", j, entry.N_V[j]),
                    "give densities of zero or more")
            .parameter("N_V");
  } else {
    const SizeLaw law(o.kind, o.mean, o.sd, o.min,
                      o.max > 0 || o.class_edges.empty() ? o.max : o.class_edges.back());
    d.class_edges = o.class_edges;
    if (d.class_edges.empty()) {
      for (int i = 0; i <= o.classes; ++i)
        d.class_edges.push_back(law.min() + (law.max() - law.min()) * i / o.classes);
    }
    check_edges(d.class_edges);
    for (std::size_t j = 0; j + 1 < d.class_edges.size(); ++j)
      entry.N_V.push_back(law.share(d.class_edges[j], d.class_edges[j + 1]));
  }
  if (o.by_volume)
    for (std::size_t j = 0; j < entry.N_V.size(); ++j)
      entry.N_V[j] /= mean_cube(d.class_edges[j], d.class_edges[j + 1]);

  const double unit = unit_volume(shapes);
  double number = 0, volume = 0;
  for (std::size_t j = 0; j < entry.N_V.size(); ++j) {
    number += entry.N_V[j];
    volume += entry.N_V[j] * unit * mean_cube(d.class_edges[j], d.class_edges[j + 1]);
  }
  if (!(number > 0))
    throw Error("bad-classes", "the size classes hold no particles",
                written ? "give a positive N_V" : "widen class_edges");
  const double scale = o.volume_fraction > 0  ? o.volume_fraction / volume
                       : o.number_density > 0 ? o.number_density / number
                                              : 1;
  for (double& n : entry.N_V) n *= scale;
  entry.low = entry.high = entry.N_V;
  d.volume_fraction = volume * scale;
  if (!(d.volume_fraction < 1))
    throw Error("bad-classes",
                fmt::format("the particles would fill {:.3g} times the volume", d.volume_fraction),
                "lower the densities")
        .parameter(written && !(o.number_density > 0) ? "N_V" : "number_density");
  d.d_max = d.class_edges.back();
  d.shapes.push_back(std::move(entry));
  return d;
}

}  // namespace terrazzo
