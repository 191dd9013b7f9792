#include "nodes/photograph/segment/network/majority.h"

#include <algorithm>

#include "nodes/data/indices.h"

namespace terrazzo::segment {

std::vector<std::int32_t> majority(const std::vector<std::int32_t>& labels, int width, int height, int reach,
                                   const Work& work) {
  std::vector<std::int32_t> out = labels;
  work.parallel(height, 16, [&](std::size_t b, std::size_t e) {
    std::vector<std::int32_t> around;
    for (int y = b; y < static_cast<int>(e); ++y)
      for (int x = 0; x < width; ++x) {
        const std::size_t i = pixel_at(x, y, width);
        around.clear();
        bool mixed = false;
        for (int v = std::max(0, y - reach); v <= std::min(height - 1, y + reach); ++v)
          for (int u = std::max(0, x - reach); u <= std::min(width - 1, x + reach); ++u) {
            around.push_back(labels[pixel_at(u, v, width)]);
            mixed = mixed || around.back() != labels[i];
          }
        if (!mixed) continue;
        std::sort(around.begin(), around.end());
        auto most = std::count(around.begin(), around.end(), labels[i]);
        for (std::size_t k = 0; k < around.size();) {
          std::size_t end = k;
          while (end < around.size() && around[end] == around[k]) ++end;
          if (static_cast<std::ptrdiff_t>(end - k) > most) {
            most = end - k;
            out[i] = around[k];
          }
          k = end;
        }
      }
  });
  return out;
}

}  // namespace terrazzo::segment
