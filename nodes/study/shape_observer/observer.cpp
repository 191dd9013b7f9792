#include "nodes/study/shape_observer/observer.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "nodes/common/stereology/outline_features.h"
#include "runtime/random.h"

namespace terrazzo::shape_observer {

namespace {

constexpr int kFolds = 9;
constexpr std::array<double, kOutlineFeatures> kVisible{0.0012, 0.12,  0.03, 0.006, 4,   0.7,
                                                        0.02,   0.015, 0.1,  0.05,  0.15};
constexpr Eigen::Index kFeatures = kOutlineFeatures;

// One row per view; columns: means, then standard deviations (if a view has at least five profiles).
Eigen::MatrixXd views_of(const Shapes& shapes, const ObserverOptions& choice, std::uint64_t seed,
                         const Work& work) {
  const auto n = static_cast<std::size_t>(choice.views) * choice.profiles;
  // A section shows one profile or more; only the first n profiles are used.
  const auto sections = random_sections(shapes, n, {SectionKind::Random, seed, 0}, work.part(0, 0.5));
  std::vector<const Loop*> loops;
  for (const auto& section : sections)
    for (const auto& profile : section)
      if (loops.size() < n) loops.push_back(&profile[0]);
  std::vector<OutlineFeatures> features(loops.size());
  work.part(0.5, 1).parallel(loops.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      features[i] = outline_features(*loops[i], {choice.points, 0});
      Random error(seed, 303, i);
      for (std::size_t k = 0; k < kOutlineFeatures; ++k)
        features[i].values[k] += choice.eyesight * kVisible[k] * error.normal();
    }
  });
  const bool spread = choice.profiles >= 5;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(choice.views, spread ? 2 * kFeatures : kFeatures);
  for (Eigen::Index v = 0; v < choice.views; ++v)
    for (Eigen::Index k = 0; k < kFeatures; ++k) {
      double sum = 0, square = 0;
      for (int p = 0; p < choice.profiles; ++p) {
        const double f = features[v * choice.profiles + p].values[k];
        sum += f;
        square += f * f;
      }
      const double mean = sum / choice.profiles;
      out(v, k) = mean;
      if (spread) out(v, kFeatures + k) = std::sqrt(std::max(0.0, square / choice.profiles - mean * mean));
    }
  return out;
}

}  // namespace

Verdict observe(const Shapes& original, const Shapes& decoy, const ObserverOptions& choice,
                const Work& work) {
  Eigen::MatrixXd a = views_of(original, choice, 2 * choice.seed, work.part(0, 0.5)),
                  b = views_of(decoy, choice, 2 * choice.seed + 1, work.part(0.5, 1));
  const auto d = a.cols();
  // In units of the spread of all views. Features that never vary are ignored.
  Eigen::VectorXd scale(d);
  for (Eigen::Index k = 0; k < d; ++k) {
    const double mean = (a.col(k).mean() + b.col(k).mean()) / 2;
    const double sd =
        std::sqrt(((a.col(k).array() - mean).square().sum() + (b.col(k).array() - mean).square().sum()) /
                  (2 * choice.views));
    scale[k] = sd > 1e-9 * (1 + std::abs(mean)) ? 1 / sd : 0;
    a.col(k) *= scale[k];
    b.col(k) *= scale[k];
  }
  double told = 0;
  for (int fold = 0; fold < kFolds; ++fold) {
    work.check();
    Eigen::VectorXd mean_a = Eigen::VectorXd::Zero(d);
    Eigen::VectorXd mean_b = mean_a;
    double n = 0;
    for (Eigen::Index v = 0; v < choice.views; ++v)
      if (v % kFolds != fold) {
        mean_a += a.row(v);
        mean_b += b.row(v);
        ++n;
      }
    mean_a /= n;
    mean_b /= n;
    Eigen::MatrixXd cov = Eigen::MatrixXd::Zero(d, d);
    for (Eigen::Index v = 0; v < choice.views; ++v)
      if (v % kFolds != fold) {
        const Eigen::VectorXd x = a.row(v).transpose() - mean_a;
        const Eigen::VectorXd y = b.row(v).transpose() - mean_b;
        cov += (x * x.transpose() + y * y.transpose()) / (2 * n);
      }
    const Eigen::VectorXd diagonal = cov.diagonal();
    cov *= 0.9;
    cov.diagonal() += 0.1 * diagonal + Eigen::VectorXd::Constant(d, 1e-9);
    const Eigen::VectorXd w = cov.ldlt().solve(mean_b - mean_a);
    for (Eigen::Index v = fold; v < choice.views; v += kFolds) {
      const double difference = w.dot(b.row(v).transpose() - a.row(v).transpose());
      told += difference > 0 ? 1 : difference == 0 ? 0.5 : 0;
    }
  }
  Verdict out;
  out.told = told / choice.views;
  out.error = std::sqrt(std::max(out.told * (1 - out.told), 0.25 / choice.views) / choice.views);
  Eigen::Index most = 0;
  (b.colwise().mean() - a.colwise().mean()).cwiseAbs().maxCoeff(&most);
  out.by = (most >= kFeatures ? "spread of " : "") + outline_feature_names()[most % kFeatures];
  return out;
}

}  // namespace terrazzo::shape_observer
