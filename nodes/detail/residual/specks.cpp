#include "nodes/detail/residual/specks.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/rank.h"

namespace terrazzo::residual {

std::vector<std::size_t> find_specks(const Vec3f* encoded, const std::vector<std::uint8_t>& binder,
                                     double limit) {
  Vec3f middle = Vec3f::Zero(), reach = Vec3f::Zero();
  std::vector<float> v;
  for (int c = 0; c < 3; ++c) {
    v.clear();
    for (std::size_t i = 0; i < binder.size(); ++i)
      if (binder[i]) v.push_back(encoded[i][c]);
    if (v.empty()) return {};
    middle[c] = median(v);
    for (float& x : v) x = std::abs(x - middle[c]);
    reach[c] = limit * std::max(1.4826 * median(v), 0.002);
  }
  std::vector<std::size_t> far;
  for (std::size_t i = 0; i < binder.size(); ++i)
    if (binder[i] && !((encoded[i] - middle).cwiseAbs().array() <= reach.array()).all()) far.push_back(i);
  return far;
}

}  // namespace terrazzo::residual
