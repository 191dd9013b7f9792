#include "nodes/common/texture/phase_statistics.h"

#include <algorithm>

namespace terrazzo {

PhaseStatistics phase_statistics(const std::vector<Phase>& pictures, int reach) {
  const auto n = static_cast<std::size_t>(reach) + 1;
  std::vector<double> both(n, 0), whole(n, 0), all(n, 0);
  const auto line = [&](const std::uint8_t* first, int length, int stride) {
    int run = 0;
    for (int i = 0; i < length; ++i) {
      const std::uint8_t* p = first + static_cast<std::ptrdiff_t>(i) * stride;
      run = *p ? run + 1 : 0;
      // Segments that end at this pixel.
      for (int r = 0; r <= std::min(i, reach); ++r) {
        const std::size_t k = r;
        ++all[k];
        if (!*p) continue;
        both[k] += p[-static_cast<std::ptrdiff_t>(r) * stride];
        whole[k] += run > r;
      }
    }
  };
  for (const Phase& p : pictures) {
    for (int y = 0; y < p.height; ++y) line(&p.in[static_cast<std::size_t>(y) * p.width], p.width, 1);
    for (int x = 0; x < p.width; ++x) line(&p.in[x], p.height, p.width);
  }
  PhaseStatistics out;
  for (std::size_t k = 0; k < n; ++k) {
    out.two_point.push_back(all[k] > 0 ? both[k] / all[k] : 0);
    out.lineal_path.push_back(all[k] > 0 ? whole[k] / all[k] : 0);
  }
  return out;
}

}  // namespace terrazzo
