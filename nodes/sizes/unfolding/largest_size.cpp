#include <algorithm>
#include <cmath>

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
  // The half unit of log likelihood that is one standard error.
  constexpr double kStandardError = 0.5;
  const double hi = o.largest * (1 + 1e-9);
  const UnfoldModel least = make_model(k, classes, hi, smallest_visible);
  std::vector<double> size(kCandidates), likelihood(kCandidates);
  work.parallel(kCandidates, 1, [&](std::size_t c, std::size_t) {
    const double d = size[c] = hi * std::pow(kRatio, static_cast<double>(c));
    // All candidates share the size classes up to the largest profile, so that they differ only in the sizes
    // above it, and the fine profile classes. One more of these shows that no profile was seen there.
    std::vector<double> sizes(least.edges.begin() + least.first, least.edges.end()), fine;
    while (sizes.back() < d * (1 - 1e-9)) sizes.push_back(std::min(d, sizes.back() + hi / classes));
    const double lo = std::max(smallest_visible, 0.0);
    for (int i = 0; i <= kFine; ++i) fine.push_back(lo + (hi - lo) * i / kFine);
    if (d > hi * (1 + 1e-9)) fine.push_back(d);
    double sum = 0;
    Eigen::MatrixXd m;
    for (std::size_t i = 0; i < own.size(); ++i) {
      const Observation& q = o.classes[i];
      if (q.size.empty()) continue;
      work.check();
      if (m.size() == 0 || depends_on_class(k, types))
        m = model_matrix(own[i], fine, sizes, least.upper_edge) * o.area;
      const Counts n = count(q.size, q.weight, fine);
      // Weighted profiles carry less information, by the factor Σw²/Σw.
      const double information = n.sum.sum() / n.squares.sum();
      sum += information * poisson_fit(m, n.sum, kIterations).log_likelihood;
    }
    likelihood[c] = sum;
  });
  const double most = *std::max_element(likelihood.begin(), likelihood.end());
  const auto enough = [&](double l) { return l >= most - kStandardError; };
  return size[std::find_if(likelihood.begin(), likelihood.end(), enough) - likelihood.begin()];
}

}  // namespace terrazzo::unfolding
