#include "nodes/study/unfold_study/study.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "nodes/sizes/unfolding/unfold.h"
#include "nodes/study/unfold_study/sample_profiles.h"

namespace terrazzo::unfold_study {
namespace {
using namespace unfolding;

struct Trial {
  bool refused = false;
  double error = 0, total = 0;
  int held = 0, intervals = 0;
  std::vector<double> edges, N_V;
};

Trial judge(const TrueSizes& truth, const SizeDistribution& d, bool intervals) {
  Trial t;
  t.edges = d.class_edges;
  double inside = 0;
  for (std::size_t j = 0; j < d.classes(); ++j) {
    double value = 0, low = 0, high = 0;
    for (const auto& e : d.shapes) {
      value += e.N_V[j];
      low += e.low[j];
      high += e.high[j];
    }
    const double actual = truth.between(d.class_edges[j], d.class_edges[j + 1]);
    t.N_V.push_back(value);
    t.error += std::abs(value - actual);
    t.total += value;
    inside += actual;
    if (!intervals) continue;
    const double rounding = 1e-9 * truth.total();
    t.held += actual >= low - rounding && actual <= high + rounding;
    ++t.intervals;
  }
  t.error = (t.error + truth.total() - inside) / truth.total();
  t.total /= truth.total();
  return t;
}

// Moves the classes of the first trial that was not refused.
MethodResult summary_of(const std::string& method, std::span<Trial> trials) {
  MethodResult out;
  out.method = method;
  double squares = 0;
  int held = 0, intervals = 0;
  for (Trial& t : trials) {
    if (t.refused) {
      ++out.refused;
      continue;
    }
    if (out.N_V.empty()) {
      out.edges = std::move(t.edges);
      out.N_V = std::move(t.N_V);
    }
    out.error += t.error;
    squares += t.error * t.error;
    out.total += t.total;
    held += t.held;
    intervals += t.intervals;
  }
  const double n = count_of(trials) - out.refused;
  const double none = std::numeric_limits<double>::quiet_NaN();
  out.error = n > 0 ? out.error / n : none;
  out.total = n > 0 ? out.total / n : none;
  out.error_of_mean = n > 1 ? std::sqrt(std::max(0.0, squares / n - out.error * out.error) / (n - 1)) : none;
  out.coverage = intervals > 0 ? static_cast<double>(held) / intervals : none;
  return out;
}

}  // namespace

std::vector<MethodResult> study(const SizeDistribution& distribution, const KMatrix& k,
                                const StudyOptions& options, const Work& work) {
  const TrueSizes truth(distribution);
  const ProfileSampler sampler(truth, k);
  KMatrix upper = k;
  upper.averaging = "upper_edge";
  const std::size_t methods = options.methods.size(), repetitions = options.repetitions;
  std::vector<Trial> trials(methods * repetitions);
  work.parallel(repetitions, 1, [&](std::size_t r, std::size_t) {
    const Profiles profiles = sampler.sample(options.profiles, options.sections, options.seed, r, work);
    // Estimated once per repetition, so that all methods have equal classes.
    double d_max = options.largest == LargestSize::Known ? truth.largest() : 0;
    if (options.largest == LargestSize::LargestProfile)
      for (const Profile& p : profiles.profiles)
        d_max = std::max(d_max, std::sqrt(4 * p.area / std::numbers::pi));
    for (std::size_t m = 0; m < methods; ++m) {
      work.check();
      const std::string& method = options.methods[m];
      const bool paper = method == "equation 4";
      UnfoldOptions o;
      o.method = method == "em" ? Method::Em : method == "nnls" ? Method::Nnls : Method::Inverse;
      o.classes = options.classes;
      o.seed = options.seed + r;
      o.bootstrap = o.method == Method::Inverse ? 0 : options.bootstrap;
      o.d_max = d_max;
      if (options.largest == LargestSize::Known) o.smallest_visible = 0;
      try {
        const SizeDistribution found = unfold(profiles, paper ? upper : k, o, work.quiet()).distribution;
        trials[m * repetitions + r] = judge(truth, found, o.bootstrap > 0);
        d_max = found.d_max;
      } catch (const Error& e) {
        if (e.diagnostic().code != "unstable" && e.diagnostic().code != "singular") throw;
        trials[m * repetitions + r].refused = true;
      }
    }
  });

  std::vector<MethodResult> results;
  for (std::size_t m = 0; m < methods; ++m) {
    const std::span of_method(trials.data() + m * repetitions, repetitions);
    results.push_back(summary_of(options.methods[m], of_method));
  }
  return results;
}

}  // namespace terrazzo::unfold_study
