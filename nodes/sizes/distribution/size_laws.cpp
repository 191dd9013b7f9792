#include "nodes/sizes/distribution/size_laws.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/stereology/size_kernel.h"

namespace terrazzo::distribution {
namespace {

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

// Volume of a particle of size 1 and this shape.
double unit_volume(const Shape& s) {
  if (!(s.volume > 0 && s.max_section_area > 0))
    throw Error("unmeasured-shape", "the shape '" + s.name + "' has no volume or no largest section");
  return s.volume / std::pow(s.size(), 3);
}

// The same, averaged over the shapes.
double unit_volume(const Shapes* shapes) {
  if (!shapes || shapes->shapes.empty()) return std::numbers::pi / 6;
  double sum = 0, total = 0;
  for (const auto& s : shapes->shapes) {
    sum += s.probability * unit_volume(s);
    total += s.probability;
  }
  return sum / total;
}

// Particles of one volume: their shapes differ in size.
SizeDistribution equal_volume(const SizeLaw& law, const Shapes* shapes) {
  struct Kind {
    int shape;
    double size, share;
  };
  std::vector<Kind> kinds;
  double total = 0;
  if (!shapes || shapes->shapes.empty()) {
    if (law.types == Types::ByClass)
      throw Error("no-shapes", "types: by_class needs shapes, but none are connected", "connect shapes")
          .parameter("types");
    kinds.push_back({-1, std::cbrt(law.volume * 6 / std::numbers::pi), 1});
    total = 1;
  } else {
    for (std::size_t s = 0; s < shapes->shapes.size(); ++s) {
      const Shape& shape = shapes->shapes[s];
      kinds.push_back({static_cast<int>(s), std::cbrt(law.volume / unit_volume(shape)), shape.probability});
      total += shape.probability;
    }
  }
  std::stable_sort(kinds.begin(), kinds.end(), [](const Kind& a, const Kind& b) { return a.size < b.size; });
  SizeDistribution out;
  std::vector<std::size_t> class_of;
  for (const Kind& k : kinds) {
    const double lo = k.size * (1 - kEqualVolumeWidth), hi = k.size * (1 + kEqualVolumeWidth);
    if (out.class_edges.empty() || lo > out.class_edges.back()) {
      out.class_edges.push_back(lo);  // between two classes lies one without particles
      out.class_edges.push_back(hi);
    } else {
      out.class_edges.back() = hi;
    }
    class_of.push_back(out.class_edges.size() - 2);
  }
  const double fraction = law.number_density >= 0    ? law.number_density * law.volume
                          : law.volume_fraction >= 0 ? law.volume_fraction
                                                     : 0.3;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    SizeDistribution::Entry e;
    e.shape = kinds[i].shape;
    e.cls = law.types == Types::ByClass ? kinds[i].shape : 0;
    e.N_V.assign(out.classes(), 0);
    e.N_V[class_of[i]] = fraction / law.volume * kinds[i].share / total;
    e.low = e.high = e.N_V;
    out.shapes.push_back(std::move(e));
  }
  std::stable_sort(out.shapes.begin(), out.shapes.end(),
                   [](const auto& a, const auto& b) { return a.shape < b.shape; });
  out.volume_fraction = fraction;
  out.d_max = out.class_edges.back();
  return out;
}

// Fractions that no packing can have.
void check_fraction(double fraction) {
  if (!(fraction > 0))
    throw Error("bad-classes", "the distribution has no particles",
                "raise volume_fraction or number_density");
  if (fraction > 1 + 1e-9)
    throw Error("too-full", fmt::format("the particles would fill {:.3g} of the volume", fraction),
                "lower the densities or the sizes");
}

std::vector<double> law_edges(const SizeLaw& law) {
  double lo = law.min, hi = law.max;
  if (law.kind == LawKind::Uniform && !(hi > lo))
    throw Error("bad-range", fmt::format("max must be above min; min is {} mm and max {} mm", lo, hi),
                "set max above min")
        .parameter("max");
  if (!(hi > 0)) {
    // Bisection for the size that 0.1 % exceed.
    hi = law.mean;
    while (law_cdf(law, hi) < 0.999) hi *= 2;
    double below = lo;
    for (int i = 0; i < 100; ++i) (law_cdf(law, (below + hi) / 2) < 0.999 ? below : hi) = (below + hi) / 2;
  }
  if (!(hi > lo))
    throw Error("bad-range", fmt::format("max must be above min; min is {} mm and max {} mm", lo, hi),
                "set max above min")
        .parameter("max");
  std::vector<double> edges;
  for (int i = 0; i <= law.classes; ++i) edges.push_back(lo + (hi - lo) * i / law.classes);
  return edges;
}

void check_classes(const SizeLaw& law) {
  const auto& e = law.class_edges;
  if (e.size() < 2 || law.N_V.size() + 1 != e.size())
    throw Error(
        "bad-classes",
        fmt::format("n classes need n + 1 class_edges and n values of N_V; there are {} edges and {} values",
                    e.size(), law.N_V.size()))
        .parameter("class_edges");
  for (std::size_t i = 0; i + 1 < e.size(); ++i)
    if (!(e[i] >= 0 && e[i + 1] > e[i]))
      throw Error(
          "bad-classes",
          fmt::format("class_edges must be 0 or more and increase; {} is followed by {}", e[i], e[i + 1]))
          .parameter("class_edges");
  if (!std::any_of(law.N_V.begin(), law.N_V.end(), [](double v) { return v > 0; }))
    throw Error("bad-classes", "all values of N_V are zero; at least one must be positive").parameter("N_V");
  for (const bool upper : {false, true}) {
    const auto& ends = upper ? law.high : law.low;
    const char* name = upper ? "high" : "low";
    if (ends.empty()) continue;
    if (ends.size() != law.N_V.size())
      throw Error("bad-classes",
                  fmt::format("{} has {} values, but N_V has {}", name, ends.size(), law.N_V.size()))
          .parameter(name);
    for (std::size_t i = 0; i < ends.size(); ++i)
      if (upper ? ends[i] < law.N_V[i] : ends[i] > law.N_V[i])
        throw Error("bad-classes", fmt::format("N_V of class {} is {}, which is {} {} = {}", i, law.N_V[i],
                                               upper ? "above" : "below", name, ends[i]))
            .parameter(name);
  }
}

}  // namespace

double law_cdf(const SizeLaw& law, double d) {
  if (law.kind == LawKind::Uniform) return std::clamp((d - law.min) / (law.max - law.min), 0.0, 1.0);
  if (law.kind == LawKind::Normal) return normal_cdf((d - law.mean) / law.sd);
  if (d <= 0) return 0;
  if (law.kind == LawKind::RosinRammler) return 1 - std::exp(-std::pow(d / law.mean, law.exponent));
  const double s2 = std::log1p(law.sd * law.sd / (law.mean * law.mean));
  return normal_cdf((std::log(d / law.mean) + s2 / 2) / std::sqrt(s2));
}

void check_law(const SizeLaw& law) {
  if (law.volume_fraction >= 0 && law.number_density >= 0)
    throw Error("both-given", "volume_fraction and number_density are both set", "set only one of them")
        .parameter("number_density");
  if (law.volume_fraction > 1)
    throw Error("too-full", fmt::format("volume_fraction must be at most 1; it is {}", law.volume_fraction))
        .parameter("volume_fraction");
  if (law.kind == LawKind::EqualVolume) return;
  law.kind == LawKind::Classes ? check_classes(law) : static_cast<void>(law_edges(law));
}

SizeDistribution make_distribution(const SizeLaw& law, const Shapes* shapes) {
  check_law(law);
  if (law.kind == LawKind::EqualVolume) {
    SizeDistribution out = equal_volume(law, shapes);
    check_fraction(out.volume_fraction);
    return out;
  }
  SizeDistribution out;
  SizeDistribution::Entry e;
  e.shape = -1;
  if (law.kind == LawKind::Classes) {
    out.class_edges = law.class_edges;
    e.N_V = law.N_V;
    e.low = law.low;
    e.high = law.high;
  } else {
    out.class_edges = law_edges(law);
    for (std::size_t i = 0; i + 1 < out.class_edges.size(); ++i) {
      const double lo = out.class_edges[i], hi = out.class_edges[i + 1];
      const double share = law_cdf(law, hi) - law_cdf(law, lo);
      e.N_V.push_back(law.density_by == DensityBy::Volume ? share / mean_cube(lo, hi) : share);
    }
  }
  const double unit = unit_volume(shapes);
  double number = 0, volume = 0;
  for (std::size_t i = 0; i < e.N_V.size(); ++i) {
    number += e.N_V[i];
    volume += e.N_V[i] * unit * mean_cube(out.class_edges[i], out.class_edges[i + 1]);
  }
  if (!(number > 0))
    throw Error("bad-range", "the law has no particles between min and max").parameter("min");
  double factor = 1;
  if (law.number_density >= 0)
    factor = law.number_density / number;
  else if (law.volume_fraction >= 0 || law.kind != LawKind::Classes)
    factor = (law.volume_fraction >= 0 ? law.volume_fraction : 0.3) / volume;
  for (auto* list : {&e.N_V, &e.low, &e.high})
    for (double& v : *list) v *= factor;
  if (e.low.empty()) e.low = e.N_V;
  if (e.high.empty()) e.high = e.N_V;
  out.volume_fraction = volume * factor;
  check_fraction(out.volume_fraction);
  out.d_max = out.class_edges.back();
  if (law.types == Types::Mixed) {
    out.shapes.push_back(std::move(e));
    return out;
  }
  if (!shapes || shapes->shapes.empty())
    throw Error("no-shapes", "types: by_class needs shapes, but none are connected", "connect shapes")
        .parameter("types");
  double probability = 0;
  for (const Shape& s : shapes->shapes) probability += s.probability;
  for (std::size_t s = 0; s < shapes->shapes.size(); ++s) {
    SizeDistribution::Entry part = e;
    part.shape = part.cls = s;
    for (auto* list : {&part.N_V, &part.low, &part.high})
      for (double& v : *list) v *= shapes->shapes[s].probability / probability;
    out.shapes.push_back(std::move(part));
  }
  return out;
}

}  // namespace terrazzo::distribution
