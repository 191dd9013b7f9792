#include "nodes/study/unfold_study/sample_profiles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/stereology/size_kernel.h"
#include "runtime/random.h"

namespace terrazzo::unfold_study {
namespace {

constexpr int kQuantiles = 8192;

}  // namespace

TrueSizes::TrueSizes(const SizeDistribution& d) : edges_(d.class_edges), N_V_(d.classes(), 0.0) {
  for (const auto& e : d.shapes)
    for (std::size_t j = 0; j < N_V_.size() && j < e.N_V.size(); ++j) N_V_[j] += e.N_V[j];
  for (const double v : N_V_) total_ += v;
  if (!(total_ > 0) || !(edges_.back() > 0))
    throw Error("no-sizes", "a distribution has no particles", "connect a distribution with particles");
}

double TrueSizes::between(double low, double high) const {
  double sum = 0;
  for (std::size_t j = 0; j < N_V_.size(); ++j) {
    const double a = edges_[j], b = edges_[j + 1];
    if (b > a)
      sum += N_V_[j] * std::max(0.0, std::min(b, high) - std::max(a, low)) / (b - a);
    else if (a > low && a <= high)
      sum += N_V_[j];
  }
  return sum;
}

double TrueSizes::profiles_between(double low, double high) const {
  double sum = 0, all = 0;
  for (std::size_t j = 0; j < N_V_.size(); ++j) {
    const double a = edges_[j], b = edges_[j + 1];
    const double from = std::clamp(low, a, b), to = std::clamp(high, a, b);
    all += N_V_[j] * (a + b) / 2;
    if (b > a)
      sum += N_V_[j] * (to * to - from * from) / (2 * (b - a));
    else if (a > low && a <= high)
      sum += N_V_[j] * a;
  }
  return sum / all;
}

ProfileSampler::ProfileSampler(const TrueSizes& truth, const KMatrix& k) : k_(k) {
  double probability = 0, seen = 0;
  for (const auto& e : k.shapes) probability += e.probability;
  if (!(probability > 0))
    throw Error("no-shapes", "the K matrix has no shapes", "connect the kmatrix output of a KMatrix node");
  for (std::size_t s = 0; s < k.shapes.size(); ++s) {
    const auto& e = k.shapes[s];
    const double unit = std::sqrt(4 * e.max_section_area / std::numbers::pi);
    for (std::size_t j = 0; j < truth.density().size(); ++j) {
      const double low = truth.edges()[j], high = truth.edges()[j + 1];
      seen += e.probability / probability * truth.density()[j] * (low + high) / 2 * e.mean_caliper / unit *
              e.profiles_per_caliper;
      sources_.push_back({low, high, seen, s});
    }
    auto& q = quantiles_.emplace_back(kQuantiles + 1);
    double at = 0;
    for (int i = 0; i <= kQuantiles; ++i) {  // by bisection, starting at the previous quantile
      double lo = at, hi = 1;
      for (int step = 0; step < 40; ++step) {
        const double middle = (lo + hi) / 2;
        (cdf_at(e.cdf, middle) < static_cast<double>(i) / kQuantiles ? lo : hi) = middle;
      }
      q[i] = at = hi;
    }
    q[0] = 0;
  }
}

Profiles ProfileSampler::sample(double expected, int sections, std::uint64_t seed, std::uint64_t repetition,
                                const Work& work) const {
  Random random(seed, 0, repetition);
  // Normal approximation of the Poisson distribution: for the relevant numbers its error is
  // far below the spread.
  const double drawn = std::round(expected + std::sqrt(expected) * random.normal());
  const std::size_t count = std::max(3.0, drawn);
  Profiles p;
  p.sections = sections;
  p.observed_area = expected / sources_.back().seen;
  p.profiles.reserve(count);
  double covered = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 65536 == 0) work.check();
    const double u = random.uniform() * sources_.back().seen;
    const auto source = std::lower_bound(sources_.begin(), sources_.end() - 1, u,
                                         [](const Source& s, double value) { return s.seen < value; });
    // Within a class, too, planes meet larger particles more often.
    const double size = std::sqrt(random.uniform(source->low * source->low, source->high * source->high));
    const auto& q = quantiles_[source->shape];
    const double at = random.uniform() * kQuantiles;
    const std::size_t b = at;
    const double relative = q[b] + (at - b) * (q[b + 1] - q[b]);
    const double diameter = size * relative;
    if (!(diameter > 0)) continue;
    Profile& f = p.profiles.emplace_back();
    f.area = std::numbers::pi / 4 * diameter * diameter;
    f.section = i % sections;
    covered += f.area;
  }
  p.area_fraction = std::min(1.0, covered / p.observed_area);
  return p;
}

}  // namespace terrazzo::unfold_study
