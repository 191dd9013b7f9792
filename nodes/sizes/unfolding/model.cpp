#include "nodes/sizes/unfolding/model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "graph/diagnostic.h"
#include "nodes/common/stereology/size_kernel.h"

namespace terrazzo::unfolding {
namespace {

void check(const KMatrix& k) {
  const auto bad = [](const std::string& what) {
    throw Error("bad-kmatrix", what, "connect the kmatrix output of a KMatrix node");
  };
  if (k.shapes.empty()) bad("the K matrix has no shapes");
  for (std::size_t i = 0; i < k.shapes.size(); ++i) {
    const auto& e = k.shapes[i];
    if (!(e.mean_caliper > 0 && e.max_section_area > 0 && e.volume > 0 && e.profiles_per_caliper > 0 &&
          e.probability >= 0) ||
        !std::isfinite(e.mean_caliper * e.max_section_area * e.volume * e.profiles_per_caliper *
                       e.probability))
      bad(fmt::format(
          "shape {} of the K matrix lacks a mean caliper diameter, largest section, volume or probability",
          i));
    if (e.cdf.size() < 2 || !std::is_sorted(e.cdf.begin(), e.cdf.end()) || !(e.cdf.front() >= 0) ||
        !(std::abs(e.cdf.back() - 1) < 1e-6))
      bad(fmt::format("shape {} of the K matrix has no valid distribution of section areas", i));
  }
}

constexpr double kSliver = 0.05;      // of a class's width
constexpr double kWidestClass = 2.0;  // upper edge of the first visible class / lower edge

double size_of(const KMatrix::Entry& e) { return std::sqrt(4 * e.max_section_area / std::numbers::pi); }

// Edges that divide the class from `low` to `high` geometrically. The lowest part holds as many profiles as a
// class does on average: each small profile stands for many particles.
std::vector<double> division(double low, double high, const std::vector<double>& profiles, int classes) {
  if (profiles.empty() || !(low > 0) || !(high > kWidestClass * low)) return {};
  const double parts = std::ceil(std::log(high / low) / std::log(kWidestClass));
  std::vector<double> inner;
  for (double i = 1; i < parts; ++i) {
    const double edge = low * std::pow(high / low, i / parts);
    const auto below =
        std::count_if(profiles.begin(), profiles.end(), [&](double s) { return s >= low && s <= edge; });
    if (!inner.empty() || static_cast<double>(below * classes) >= profiles.size()) inner.push_back(edge);
  }
  return inner;
}

// Mean volume of particles of a size, relative to its cube.
double unit_volume(const KMatrix& k, double size) {
  double total = 0, unit = 0;
  for (const auto& e : k.shapes) {
    const double weight = e.probability * e.trend.factor(size);
    total += weight;
    unit += weight * e.volume / std::pow(size_of(e), 3);
  }
  return unit / total;
}

// Mean height of lying stones relative to their size: that of ellipsoids with their volume and largest
// section, which is their silhouette. 1 for balls.
double relative_height(const KMatrix& k) {
  double sum = 0, total = 0;
  for (const auto& e : k.shapes) {
    sum += e.probability * 1.5 * e.volume / (e.max_section_area * size_of(e));
    total += e.probability;
  }
  return total > 0 ? sum / total : 1;
}

}  // namespace

std::vector<double> shape_shares(const KMatrix& k, double size) {
  double total = 0;
  std::vector<double> shares;
  for (const auto& e : k.shapes) {
    shares.push_back(e.probability * e.trend.factor(size));
    total += shares.back();
  }
  for (double& share : shares) share /= total;
  return shares;
}

Eigen::MatrixXd model_matrix(const KMatrix& k, const std::vector<double>& profile_edges,
                             const std::vector<double>& size_edges, bool upper_edge, Bed bed) {
  if (bed != Bed::None) return Hiding(bed, relative_height(k)).matrix(profile_edges, size_edges);
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(profile_edges.size() - 1, size_edges.size() - 1);
  std::vector<std::vector<double>> shares;
  for (Eigen::Index j = 0; j < m.cols(); ++j)
    shares.push_back(shape_shares(k, (size_edges[j] + size_edges[j + 1]) / 2));
  for (std::size_t s = 0; s < k.shapes.size(); ++s) {
    const auto& e = k.shapes[s];
    if (!(e.probability > 0)) continue;
    const double caliper = e.mean_caliper / size_of(e) * size_edges.back();
    const Eigen::MatrixXd kernel = size_kernel(e, profile_edges, size_edges, upper_edge);
    for (Eigen::Index j = 0; j < m.cols(); ++j) m.col(j) += shares[j][s] * caliper * kernel.col(j);
  }
  return m;
}

UnfoldModel make_model(const KMatrix& k, int classes, double d_max, double smallest_visible,
                       const std::vector<double>& profiles, Bed bed) {
  check(k);
  UnfoldModel m;
  m.equal = classes;
  m.upper_edge = k.averaging == "upper_edge";
  m.edges = equal_edges(classes, d_max);
  if (!(smallest_visible < d_max))
    throw Error(
        "nothing-visible",
        fmt::format(
            "smallest_visible must be below the size of the largest particle, {:.4g} mm; it is {:.4g} mm",
            d_max, smallest_visible),
        "lower smallest_visible")
        .parameter("smallest_visible");
  // Smaller particles show no visible profile, so the first class starts at the smallest visible size.
  // Instead of a sliver of a class, which would hold hardly any profiles, the next one starts there.
  const double sliver = kSliver * d_max / classes;
  while (m.first + 1 < classes && m.edges[m.first + 1] <= smallest_visible + sliver) ++m.first;
  m.edges[m.first] = smallest_visible;
  const std::vector<double> inner = division(smallest_visible, m.edges[m.first + 1], profiles, classes);
  m.edges.insert(m.edges.begin() + m.first + 1, inner.begin(), inner.end());
  const std::vector<double> sizes(m.edges.begin() + m.first, m.edges.end());
  m.profile_edges = sizes;
  m.matrix = model_matrix(k, m.profile_edges, sizes, m.upper_edge, bed);
  for (int j = 0; j < m.visible(); ++j)
    if (!(m.matrix.col(j).sum() > 0))
      throw Error("bad-kmatrix",
                  fmt::format("according to the K matrix, particles of {:.4g} to {:.4g} mm show no profile "
                              "of {:.4g} mm or more, so their density cannot be estimated",
                              sizes[j], sizes[j + 1], smallest_visible),
                  "check the shapes, or lower smallest_visible");
  m.volume.resize(m.visible());
  for (int j = 0; j < m.visible(); ++j)
    m.volume[j] = unit_volume(k, (sizes[j] + sizes[j + 1]) / 2) * mean_cube(sizes[j], sizes[j + 1]);
  return m;
}

Counts count(const std::vector<double>& sizes, const std::vector<double>& weights,
             const std::vector<double>& edges) {
  const Eigen::Index n = edges.size() - 1;
  Counts c{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    // Classes are (lower, upper], as in the paper; the first includes its lower edge too.
    const auto at = std::lower_bound(edges.begin(), edges.end(), sizes[i]) - edges.begin();
    if (at > n || (at == 0 && sizes[i] < edges[0])) continue;
    const Eigen::Index k = std::max<Eigen::Index>(at - 1, 0);
    c.sum[k] += weights[i];
    c.squares[k] += weights[i] * weights[i];
  }
  return c;
}

}  // namespace terrazzo::unfolding
