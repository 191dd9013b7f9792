#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/compare/compare/comparison.h"
#include "nodes/compare/compare/noise.h"

namespace terrazzo::compare {

namespace {

struct Density {
  std::vector<double> value, variance;
};

void check(const SizeDistribution& d, const char* which) {
  bool good = d.class_edges.size() >= 2 && !d.shapes.empty() &&
              std::is_sorted(d.class_edges.begin(), d.class_edges.end());
  for (double e : d.class_edges) good = good && std::isfinite(e);
  for (const auto& e : d.shapes) {
    good = good && e.N_V.size() == d.classes() && e.low.size() == d.classes() && e.high.size() == d.classes();
    for (double v : e.N_V) good = good && std::isfinite(v);
  }
  if (!good)
    throw Error("no-classes", fmt::format("{} has no usable size classes", which),
                "check its class edges and N_V");
}

Density summed(const SizeDistribution& d) {
  Density s{std::vector<double>(d.classes(), 0.0), std::vector<double>(d.classes(), 0.0)};
  for (const auto& e : d.shapes)
    for (std::size_t i = 0; i < d.classes(); ++i) {
      const double sd = (e.high[i] - e.low[i]) / (2 * kSigmas90);
      s.value[i] += e.N_V[i];
      s.variance[i] += std::isfinite(sd) ? sd * sd : 0;
    }
  return s;
}

bool same(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::abs(a[i] - b[i]) > 1e-9 * b.back()) return false;
  return true;
}

// Assumes that each class is uniform over its sizes. Variances scale with the square of the share.
Density reclassed(const Density& d, const std::vector<double>& from, const std::vector<double>& to) {
  Density out{std::vector<double>(to.size() - 1, 0.0), std::vector<double>(to.size() - 1, 0.0)};
  for (std::size_t i = 0; i + 1 < from.size(); ++i)
    for (std::size_t j = 0; j + 1 < to.size(); ++j) {
      const double width = from[i + 1] - from[i];
      const double share =
          width > 0 ? std::max(0.0, std::min(from[i + 1], to[j + 1]) - std::max(from[i], to[j])) / width
                    : (from[i] > to[j] && from[i] <= to[j + 1]);
      out.value[j] += share * d.value[i];
      out.variance[j] += share * share * d.variance[i];
    }
  return out;
}

}  // namespace

Comparison compare(const SizeDistribution& a, const SizeDistribution& b, const CompareOptions& choice) {
  check(a, "a");
  check(b, "b");
  Comparison out;
  Density da = summed(a), db = summed(b);
  std::vector<double> edges = a.class_edges;
  if (!same(a.class_edges, b.class_edges)) {
    edges.clear();
    const double largest = std::max(a.class_edges.back(), b.class_edges.back());
    for (int i = 0; i <= choice.classes; ++i) edges.push_back(largest * i / choice.classes);
    da = reclassed(da, a.class_edges, edges);
    db = reclassed(db, b.class_edges, edges);
  }
  // Without a volume fraction, densities are relative.
  const char* const unit = a.volume_fraction > 0 && b.volume_fraction > 0 ? "mm⁻³" : "relative";
  double total_a = 0, total_b = 0, difference = 0, variance = 0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const double va = da.value[i], vb = db.value[i], noise = da.variance[i] + db.variance[i];
    out.numbers.push_back({"size_classes", fmt::format("N_V {}", i + 1), unit, edges[i], edges[i + 1], va, vb,
                           std::max(kSigmas95 * std::sqrt(noise), 1e-9 * std::abs(va))});
    total_a += va;
    total_b += vb;
    difference += std::abs(vb - va);
    variance += noise;
  }
  out.numbers.push_back({"size_classes", "N_V", unit, 0, 0, total_a, total_b,
                         std::max(kSigmas95 * std::sqrt(variance), 1e-9 * std::abs(total_a))});
  out.metrics["N_V_a"] = total_a;
  out.metrics["N_V_b"] = total_b;
  if (total_a > 0) out.metrics["N_V_l1"] = difference / total_a;
  out.metrics["volume_fraction_a"] = a.volume_fraction;
  out.metrics["volume_fraction_b"] = b.volume_fraction;
  out.metrics["d_max_a"] = a.d_max;
  out.metrics["d_max_b"] = b.d_max;
  return out;
}

}  // namespace terrazzo::compare
