#include "nodes/photograph/synthetic_photo/cells.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/noise.h"

namespace terrazzo::synthetic_photo {
namespace {

// Among the cells `near`, in the order of their distance to the block.
CellPlace place_of(int x, int y, double wx, double wy, const std::vector<CellSeed>& seeds,
                   const std::vector<std::size_t>& order, std::size_t near) {
  double best = 1e30, next = 1e30;
  std::size_t first = 0, second = 0;
  for (std::size_t n = 0; n < near; ++n) {
    const std::size_t k = order[n];
    const double d = seeds[k].power(wx, wy);
    if (d < best) {
      next = best;
      second = first;
      best = d;
      first = k;
    } else if (d < next) {
      next = d;
      second = k;
    }
  }
  const double apart = std::hypot(seeds[first].x - seeds[second].x, seeds[first].y - seeds[second].y);
  return {x, y, first, second, (next - best) / (2 * std::max(1.0, apart))};
}

}  // namespace

void visit_cells(const Canvas& c, const std::vector<CellSeed>& seeds, const CellWarp& warp, const Work& work,
                 const std::function<void(const CellPlace&)>& visit) {
  // Only the cells nearest to a block's center can reach into the block.
  constexpr int kBlock = 16;
  constexpr std::size_t kNearest = 40;
  std::vector<std::size_t> order(seeds.size());
  for (int by = 0; by < c.height; by += kBlock)
    for (int bx = 0; bx < c.width; bx += kBlock) {
      work.check();
      for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
      const std::size_t near = std::min(kNearest, order.size());
      std::partial_sort(order.begin(), order.begin() + near, order.end(), [&](std::size_t a, std::size_t b) {
        return seeds[a].power(bx + kBlock / 2, by + kBlock / 2) <
               seeds[b].power(bx + kBlock / 2, by + kBlock / 2);
      });
      for (int y = by; y < std::min(c.height, by + kBlock); ++y)
        for (int x = bx; x < std::min(c.width, bx + kBlock); ++x) {
          double wx = x, wy = y;
          if (warp.amount > 0) {
            wx += warp.amount * turbulence(warp.seed, Vec3(x, y, 0) / warp.size, 2);
            wy += warp.amount * turbulence(warp.seed + 3, Vec3(x, y, 0) / warp.size, 2);
          }
          visit(place_of(x, y, wx, wy, seeds, order, near));
        }
    }
}

}  // namespace terrazzo::synthetic_photo
