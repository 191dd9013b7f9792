#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/stereology/size_kernel.h"
#include "nodes/sizes/unfolding/poisson_fit.h"
#include "nodes/sizes/unfolding/unfold.h"

namespace terrazzo::unfolding {

double estimate_d_max(const Observations& o, const KMatrix& k, Types types, int classes,
                      double smallest_visible, const Work& work) {
  std::vector<KMatrix> own;
  for (std::size_t c = 0; c < o.classes.size(); ++c) own.push_back(kmatrix_of(k, types, c));
  constexpr int kCandidates = 25, kFine = 120, kIterations = 300;
  constexpr double kRatio = 1.02;
  double best = o.largest * (1 + 1e-9), most = -std::numeric_limits<double>::infinity();
  std::vector<double> likelihood(kCandidates);
  work.parallel(kCandidates, 1, [&](std::size_t c, std::size_t) {
    const double d = o.largest * (1 + 1e-9) * std::pow(kRatio, static_cast<double>(c));
    const UnfoldModel model = make_model(k, classes, d, smallest_visible);
    const std::vector<double> sizes(model.edges.begin() + model.first, model.edges.end());
    // All candidates share the fine profile classes up to the largest profile. One more class covers the
    // sizes above it, where no profile was seen.
    std::vector<double> fine;
    const double lo = std::max(smallest_visible, 0.0), hi = o.largest * (1 + 1e-9);
    for (int i = 0; i <= kFine; ++i) fine.push_back(lo + (hi - lo) * i / kFine);
    if (d > hi * (1 + 1e-9)) fine.push_back(d);
    double sum = 0;
    Eigen::MatrixXd m;
    for (std::size_t i = 0; i < own.size(); ++i) {
      const Observation& q = o.classes[i];
      if (q.size.empty()) continue;
      work.check();
      if (m.size() == 0 || depends_on_class(k, types))
        m = model_matrix(own[i], fine, sizes, model.upper_edge) * o.area;
      const Counts n = count(q.size, q.weight, fine);
      // Weighted profiles carry less information, by the factor Σw²/Σw.
      const double information = n.sum.sum() / n.squares.sum();
      sum += information * poisson_fit(m, n.sum, kIterations).log_likelihood;
    }
    likelihood[c] = sum;
  });
  for (int c = 0; c < kCandidates; ++c)
    if (likelihood[c] > most + 1e-9) {
      most = likelihood[c];
      best = o.largest * (1 + 1e-9) * std::pow(kRatio, c);
    }
  return best;
}

}  // namespace terrazzo::unfolding
