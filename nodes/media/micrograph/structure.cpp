#include "nodes/media/micrograph/structure.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/phase_statistics.h"

namespace terrazzo::media {

double directedness(const PhaseMap& map) {
  double uu = 0, vv = 0, uv = 0;
  for (int y = 0; y + 1 < map.height; ++y)
    for (int x = 0; x + 1 < map.width; ++x) {
      const std::uint8_t a = map.at[map.index(x, y)], b = map.at[map.index(x + 1, y)],
                         c = map.at[map.index(x, y + 1)], d = map.at[map.index(x + 1, y + 1)];
      if (std::max({a, b, c, d}) == kUnobserved) continue;
      for (int phase = 0; phase < map.phases; ++phase) {
        const double in[4] = {double(a == phase), double(b == phase), double(c == phase), double(d == phase)};
        const double u = (in[1] - in[0] + in[3] - in[2]) / 2, v = (in[2] - in[0] + in[3] - in[1]) / 2;
        uu += u * u;
        vv += v * v;
        uv += u * v;
      }
    }
  return uu + vv > 0 ? std::hypot(uu - vv, 2 * uv) / (uu + vv) : 0;
}

double correlation_length(const PhaseMap& picture) {
  const PhaseMap map = middle_of(picture, 2048);
  const int most = std::max(1, std::min(map.width, map.height) / 8);
  for (int reach = std::min(16, most);; reach = std::min(2 * reach, most)) {
    std::vector<double> covariance(static_cast<std::size_t>(reach) + 1, 0);
    for (int phase = 0; phase < map.phases; ++phase) {
      Phase in{map.width, map.height, map.at};
      for (std::uint8_t& p : in.in) p = p == kUnobserved ? 2 : p == phase;
      const auto s = phase_statistics({in}, reach);
      for (std::size_t r = 0; r < covariance.size(); ++r)
        covariance[r] += s.two_point[r] - s.two_point[0] * s.two_point[0];
    }
    const double limit = covariance[0] / std::exp(1.0);
    for (std::size_t r = 1; r < covariance.size(); ++r)
      if (covariance[r] < limit)
        return static_cast<double>(r - 1) + (covariance[r - 1] - limit) / (covariance[r - 1] - covariance[r]);
    if (reach == most) return most;
  }
}

}  // namespace terrazzo::media
