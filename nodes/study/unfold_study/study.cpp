#include "nodes/study/unfold_study/study.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
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
  std::vector<char> held, occupied;  // by class
  std::vector<double> edges, N_V;
};

// Intervals of classes that no profile tells of start at zero and always hold: they count from this expected
// number of profiles on.
constexpr double kOccupied = 1;

// `profiles`: their expected number, for intervals; otherwise 0.
Trial judge(const TrueSizes& truth, const SizeDistribution& d, double profiles) {
  Trial t;
  t.edges = d.class_edges;
  t.held.assign(d.classes(), false);
  t.occupied.assign(d.classes(), false);
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
    if (profiles * truth.profiles_between(d.class_edges[j], d.class_edges[j + 1]) < kOccupied) continue;
    const double rounding = 1e-9 * truth.total();
    t.held[j] = actual >= low - rounding && actual <= high + rounding;
    t.occupied[j] = true;
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
  std::vector<double> held, occupied;
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
    held.resize(std::max(held.size(), t.held.size()));
    occupied.resize(held.size());
    for (std::size_t j = 0; j < t.held.size(); ++j) {
      held[j] += t.held[j];
      occupied[j] += t.occupied[j];
    }
  }
  const double n = count_of(trials) - out.refused;
  const double none = std::numeric_limits<double>::quiet_NaN();
  out.error = n > 0 ? out.error / n : none;
  out.total = n > 0 ? out.total / n : none;
  out.error_of_mean = n > 1 ? std::sqrt(std::max(0.0, squares / n - out.error * out.error) / (n - 1)) : none;
  const auto share = [&](double part, double whole) { return whole > 0 ? part / whole : none; };
  for (std::size_t j = 0; j < held.size(); ++j) out.class_coverage.push_back(share(held[j], occupied[j]));
  out.coverage = share(std::accumulate(held.begin(), held.end(), 0.0),
                       std::accumulate(occupied.begin(), occupied.end(), 0.0));
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
        trials[m * repetitions + r] = judge(truth, found, o.bootstrap > 0 ? options.profiles : 0);
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
