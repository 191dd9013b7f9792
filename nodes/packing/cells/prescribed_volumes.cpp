#include "nodes/packing/cells/prescribed_volumes.h"

#include <fmt/format.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/periodic.h"

namespace terrazzo::tessellation {
namespace {

using Eigen::VectorXd;

constexpr int kSteps = 200;
constexpr double kShortest = 1e-7;  // step length at which the search along a direction gives up
constexpr double kCoarse = 0.03;    // tolerance between rounds
constexpr double kSolve = 1e-6;     // of the linear solver
constexpr double kPerFace = 1000;   // effort of a diagram and a step, for each side of a face

// The direction that would make all volumes right if they were linear in the weights.
VectorXd newton_direction(const CellSizes& c, const VectorXd& missing) {
  const auto n = missing.size();
  std::vector<Eigen::Triplet<double>> entries;
  VectorXd diagonal = VectorXd::Zero(n);
  for (const auto& k : c.couplings) {
    entries.emplace_back(k.a, k.b, -k.rate);
    diagonal[k.a] += k.rate;
  }
  // Weights are determined up to a constant, so the matrix is singular; a small diagonal chooses one.
  const double small = 1e-12 * diagonal.mean();
  for (Eigen::Index i = 0; i < n; ++i) entries.emplace_back(i, i, diagonal[i] + small);
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper,
                           Eigen::IncompleteCholesky<double>>
      solver;
  solver.setTolerance(kSolve);
  solver.compute(matrix);
  return solver.solve(missing);
}

double smallest(const std::vector<double>& v) { return *std::min_element(v.begin(), v.end()); }

class Fit {
 public:
  Fit(Seeds& seeds, const std::vector<double>& volume, Effort& effort, const Work& work)
      : seeds_(seeds), effort_(effort), work_(work), wanted_(volume.size()) {
    const double sum = std::accumulate(volume.begin(), volume.end(), 0.0);
    for (std::size_t i = 0; i < volume.size(); ++i) wanted_[i] = volume[i] / sum * seeds.box.prod();
  }

  VolumeFit run(double tolerance);

 private:
  Seeds& seeds_;
  Effort& effort_;
  const Work& work_;
  VectorXd wanted_;
  CellSizes now_;

  VectorXd missing(const CellSizes& c) const {
    return wanted_ - Eigen::Map<const VectorXd>(c.volume.data(), wanted_.size());
  }
  bool step(double floor);
  CellSizes sizes();
};

CellSizes Fit::sizes() {
  CellSizes c = cell_sizes(seeds_, work_.quiet());
  effort_.used += kPerFace * c.couplings.size();
  return c;
}

// Moves along Newton's direction as far as no cell becomes smaller than `floor` and the error decreases.
bool Fit::step(double floor) {
  const VectorXd missing_now = missing(now_), direction = newton_direction(now_, missing_now);
  const std::vector<double> start = seeds_.weight;
  for (double length = 1; length > kShortest; length /= 2) {
    for (std::size_t i = 0; i < start.size(); ++i) seeds_.weight[i] = start[i] + length * direction[i];
    CellSizes next = sizes();
    if (next.empty == 0 && smallest(next.volume) >= floor &&
        missing(next).norm() <= (1 - 0.1 * length) * missing_now.norm()) {
      now_ = std::move(next);
      return true;
    }
  }
  seeds_.weight = start;
  return false;
}

VolumeFit Fit::run(double tolerance) {
  VolumeFit out;
  now_ = sizes();
  if (now_.empty > 0) {
    std::fill(seeds_.weight.begin(), seeds_.weight.end(), 0.0);
    now_ = sizes();
  }
  if (now_.empty > 0)
    throw Error("not-converged", fmt::format("{} seeds share their position with another", now_.empty),
                "change `seed`");
  const double floor = 0.5 * std::min(wanted_.minCoeff(), smallest(now_.volume));
  for (;; ++out.iterations) {
    out.worst = missing(now_).cwiseQuotient(wanted_).cwiseAbs().maxCoeff();
    if (out.worst <= tolerance || effort_.spent()) return out;
    work_.progress(std::clamp(1 - std::log(out.worst / tolerance) / std::log(1e6), 0.0, 1.0),
                   fmt::format("volumes within {:.2g}", out.worst));
    if (out.iterations == kSteps || !step(floor))
      throw Error("not-converged",
                  fmt::format("the volumes of {} cells could not be met: one is off by {:.2g} of its volume",
                              seeds_.count(), out.worst),
                  "change `seed`, or leave out the smallest classes");
  }
}

}  // namespace

VolumeFit fit_volumes(Seeds& seeds, const std::vector<double>& volume, double tolerance, Effort& effort,
                      const Work& work) {
  if (seeds.count() == 0) return {};
  return Fit(seeds, volume, effort, work).run(tolerance);
}

VolumeFit fit_round_cells(Seeds& seeds, const std::vector<double>& volume, double tolerance, int rounds,
                          Effort& effort, const Work& work) {
  int iterations = 0;
  for (int k = 0; k < rounds && !effort.spent(); ++k) {
    const Work part = work.part(static_cast<double>(k) / (rounds + 1), (k + 1.0) / (rounds + 1));
    iterations += fit_volumes(seeds, volume, std::max(tolerance, kCoarse), effort, part).iterations;
    const CellSizes cells = cell_sizes(seeds, part.quiet());
    for (std::size_t i = 0; i < seeds.count(); ++i) {
      Vec3& p = seeds.position[i];
      p = wrap_point(p + cells.centroid[i], seeds.box);
    }
  }
  VolumeFit out =
      fit_volumes(seeds, volume, tolerance, effort, work.part(static_cast<double>(rounds) / (rounds + 1), 1));
  out.iterations += iterations;
  return out;
}

}  // namespace terrazzo::tessellation
