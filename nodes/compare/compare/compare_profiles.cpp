#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/compare/compare/comparison.h"
#include "nodes/compare/compare/noise.h"

namespace terrazzo::compare {

namespace {

void check(const Profiles& p, const char* which) {
  if (p.profiles.empty())
    throw Error("no-profiles", fmt::format("{} has no profiles", which),
                "check the labels in the node that made them");
  for (const Profile& q : p.profiles)
    if (!(q.area >= 0) || !std::isfinite(q.area) || !(q.weight >= 0) || !std::isfinite(q.weight))
      throw Error(
          "bad-profile",
          fmt::format("{} has a profile with area {:g} and weight {:g}; both must be finite and not negative",
                      which, q.area, q.weight));
}

double diameter(const Profile& p) { return std::sqrt(4 * p.area / M_PI); }

struct Bin {
  double weight = 0, squares = 0;
};

std::vector<Bin> bins_of(const Profiles& p, double largest, const CompareOptions& choice) {
  std::vector<Bin> bins(choice.classes);
  for (const Profile& q : p.profiles) {
    if (q.weight == 0 || diameter(q) < choice.smallest) continue;
    const int i = std::min<int>(diameter(q) / largest * choice.classes, choice.classes - 1);
    bins[i].weight += q.weight;
    bins[i].squares += q.weight * q.weight;
  }
  return bins;
}

double total(const std::vector<Bin>& bins) {
  double sum = 0;
  for (const Bin& b : bins) sum += b.weight;
  return sum;
}

// Expected variance of one set's rate, at the pooled rate of both (per unit of area, or per total).
double rate_variance(const Bin& a, double area_a, const Bin& b, double area_b, double area) {
  const double weight = a.weight + b.weight;
  if (weight == 0) return 0;
  const double rate = weight / (area_a + area_b), mean_square = (a.squares + b.squares) / weight;
  return rate * mean_square / area;
}

ComparedNumber compare_rate(const Bin& a, double area_a, const Bin& b, double area_b) {
  ComparedNumber n;
  n.measure = "size_classes";
  n.a = a.weight / area_a;
  n.b = b.weight / area_b;
  const double weight = a.weight + b.weight;
  const double variance =
      rate_variance(a, area_a, b, area_b, area_a) + rate_variance(a, area_a, b, area_b, area_b);
  const double one = weight > 0 ? (a.squares + b.squares) / weight : 0;  // mean weight of one more profile
  n.tolerance = weight > 0 ? kSigmas95 * std::sqrt(variance) + 0.5 * one * (1 / area_a + 1 / area_b) : 0;
  return n;
}

void compare_sizes(const Profiles& a, const Profiles& b, const CompareOptions& choice, Comparison& out) {
  double largest = 0;
  for (const Profiles* set : {&a, &b})
    for (const Profile& p : set->profiles)
      if (p.weight > 0) largest = std::max(largest, diameter(p));
  if (!(largest > choice.smallest) || largest == 0) {
    out.warnings.push_back(
        "size classes are not compared: no profile is whole and at least as large as smallest");
    return;
  }
  const auto bins_a = bins_of(a, largest, choice), bins_b = bins_of(b, largest, choice);
  double area_a = a.observed_area, area_b = b.observed_area;
  std::string unit = "mm⁻²";
  if (!(area_a > 0) || !(area_b > 0)) {
    out.warnings.push_back(
        "an observed area is unknown: size classes compare shares of the total number, not densities");
    area_a = total(bins_a);
    area_b = total(bins_b);
    unit = "";
    if (area_a == 0 || area_b == 0) {
      out.warnings.push_back(
          "size classes are not compared: one set has no profile that is whole and at least as large as "
          "smallest");
      return;
    }
  }
  double difference = 0, sum_a = 0, chi2 = 0, filled = 0;
  Bin all_a, all_b;
  for (int i = 0; i < choice.classes; ++i) {
    ComparedNumber n = compare_rate(bins_a[i], area_a, bins_b[i], area_b);
    n.item = fmt::format("N_A {}", i + 1);
    n.unit = unit;
    n.lower = largest * i / choice.classes;
    n.upper = largest * (i + 1) / choice.classes;
    difference += std::abs(n.b - n.a);
    sum_a += n.a;
    all_a.weight += bins_a[i].weight;
    all_a.squares += bins_a[i].squares;
    all_b.weight += bins_b[i].weight;
    all_b.squares += bins_b[i].squares;
    const double variance = rate_variance(bins_a[i], area_a, bins_b[i], area_b, area_a) +
                            rate_variance(bins_a[i], area_a, bins_b[i], area_b, area_b);
    if (variance > 0) {
      chi2 += (n.b - n.a) * (n.b - n.a) / variance;
      ++filled;
    }
    out.numbers.push_back(std::move(n));
  }
  if (unit != "") {
    ComparedNumber n = compare_rate(all_a, area_a, all_b, area_b);
    n.item = "N_A";
    n.unit = unit;
    out.metrics["N_A_a"] = n.a;
    out.metrics["N_A_b"] = n.b;
    out.numbers.push_back(std::move(n));
  }
  if (sum_a > 0) out.metrics["N_A_l1"] = difference / sum_a;
  if (filled > 0) out.metrics["N_A_chi2"] = chi2 / filled;
}

struct Fraction {
  double value = NAN, error = NAN;
};

Fraction fraction_of(const Profiles& p, const char* which, Comparison& out) {
  double sum = 0, squares = 0;
  for (const Profile& q : p.profiles) {
    sum += q.weight * q.area;
    squares += q.weight * q.area * q.area;
  }
  Fraction f;
  f.value = p.area_fraction;
  if (!(f.value > 0) && sum > 0 && p.observed_area > 0) {
    f.value = sum / p.observed_area;
    out.warnings.push_back(fmt::format(
        "{} has no area fraction: it is computed from the weighted areas of its profiles", which));
  } else if (!(f.value > 0)) {
    out.warnings.push_back(fmt::format("the area fraction of {} is unknown", which));
    return {};
  }
  if (sum > 0) f.error = f.value * std::sqrt(squares) / sum;
  return f;
}

void compare_fractions(const Profiles& a, const Profiles& b, Comparison& out) {
  const Fraction fa = fraction_of(a, "a", out), fb = fraction_of(b, "b", out);
  if (std::isnan(fa.value) || std::isnan(fb.value)) return;
  out.numbers.push_back({"area_fraction", "area fraction", "", 0, 0, fa.value, fb.value,
                         kSigmas95 * std::hypot(fa.error, fb.error)});
  out.metrics["area_fraction_a"] = fa.value;
  out.metrics["area_fraction_b"] = fb.value;
  out.metrics["area_fraction_ratio"] = fb.value / fa.value;
}

struct MeanColor {
  Vec3f linear = Vec3f::Zero();
  Eigen::Vector3d lab = Eigen::Vector3d::Zero(),
                  variance = Eigen::Vector3d::Zero();  // variance of the mean, Oklab
};

MeanColor mean_color(const Profiles& p) {
  // Profiles at the border show their colors too, so every profile is weighted by its visible area.
  MeanColor m;
  double sum = 0;
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  for (const Profile& q : p.profiles) {
    sum += q.area;
    linear += q.area * q.color.cast<double>();
    m.lab += q.area * linear_to_oklab(q.color).cast<double>();
  }
  if (!(sum > 0)) return m;
  m.linear = (linear / sum).cast<float>();
  m.lab /= sum;
  for (const Profile& q : p.profiles) {
    const Eigen::Vector3d d = linear_to_oklab(q.color).cast<double>() - m.lab;
    m.variance += (q.area / sum) * (q.area / sum) * d.cwiseProduct(d);
  }
  return m;
}

}  // namespace

Comparison compare(const Profiles& a, const Profiles& b, const CompareOptions& choice) {
  check(a, "a");
  check(b, "b");
  Comparison out;
  if (choice.size_classes) compare_sizes(a, b, choice, out);
  if (choice.area_fraction) compare_fractions(a, b, out);
  if (choice.color) {
    const MeanColor ma = mean_color(a), mb = mean_color(b);
    add_color(out, "particles", ma.linear, mb.linear, ma.lab, mb.lab, ma.variance + mb.variance);
    const Eigen::Vector3d ba = linear_to_oklab(a.binder_color).cast<double>(),
                          bb = linear_to_oklab(b.binder_color).cast<double>();
    add_color(out, "binder", a.binder_color, b.binder_color, ba, bb, Eigen::Vector3d::Zero());
  }
  if (choice.circularity) compare_outlines(a, b, "circularity", choice.smallest, out);
  if (choice.total_curvature) compare_outlines(a, b, "total_curvature", choice.smallest, out);
  return out;
}

}  // namespace terrazzo::compare
