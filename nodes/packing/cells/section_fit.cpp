#include "nodes/packing/cells/section_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/stereology/random_sections.h"

namespace terrazzo::tessellation {
namespace {

// Profile sizes of random sections of a shape at scale 1.
std::vector<double> profile_sizes(const Shape& shape, int sections, std::uint64_t seed, std::uint64_t first) {
  Shapes one;
  one.shapes = {shape};
  one.shapes[0].probability = 1;
  RandomSections how;
  how.seed = seed;
  how.first = first;
  std::vector<double> sizes;
  for (const BodySection& section : random_sections(one, sections, how))
    for (const auto& profile : section) {
      double area = 0;
      for (const Loop& loop : profile) area += loop_area(loop);
      if (area > 0) sizes.push_back(std::sqrt(4 / std::numbers::pi * area));
    }
  return sizes;
}

}  // namespace

Eigen::MatrixXd profile_densities(const Shapes& shapes, const Particles& particles,
                                  const std::vector<int>& size_class, const std::vector<double>& edges,
                                  int sections, std::uint64_t seed, const Work& work) {
  const Eigen::Index classes = edges.size() - 1;
  std::vector<std::vector<double>> sizes(shapes.shapes.size());
  std::vector<bool> used(shapes.shapes.size(), false);
  for (std::int32_t s : particles.shape) used[s] = true;
  work.parallel(sizes.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s)
      if (used[s]) sizes[s] = profile_sizes(shapes.shapes[s], sections, seed, s * sections);
  });
  Eigen::MatrixXd density = Eigen::MatrixXd::Zero(classes, classes);
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const std::int32_t s = particles.shape[i];
    const double each = shapes.shapes[s].mean_caliper * particles.scale[i] / particles.box.prod() / sections;
    for (double size : sizes[s]) {
      const auto at =
          std::upper_bound(edges.begin(), edges.end(), size * particles.scale[i]) - edges.begin() - 1;
      if (at >= 0) density(size_class[i], std::min<Eigen::Index>(at, classes - 1)) += each;
    }
  }
  return density;
}

double misfit(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return 0.5 * (a / a.sum() - b / b.sum()).cwiseAbs().sum();
}

double sampling_misfit(const Eigen::VectorXd& density, double profiles) {
  const Eigen::ArrayXd p = density.array() / density.sum();
  return 0.5 * (2 / std::numbers::pi * p * (1 - p) / profiles).sqrt().sum();
}

void correct(SizeDistribution& distribution, const Eigen::VectorXd& wanted, const Eigen::MatrixXd& shown) {
  const Eigen::VectorXd total = shown.colwise().sum();
  const Eigen::VectorXd all = shown.rowwise().sum();
  for (Eigen::Index k = 0; k < all.size(); ++k) {
    if (!(all[k] > 0)) continue;
    double factor = 0;
    for (Eigen::Index j = 0; j < total.size(); ++j)
      if (total[j] > 0) factor += shown(k, j) / all[k] * wanted[j] / total[j];
    for (auto& entry : distribution.shapes) entry.N_V[k] *= std::clamp(factor, 0.5, 2.0);
  }
}

}  // namespace terrazzo::tessellation
