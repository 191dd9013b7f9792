#include "nodes/photograph/segment/color/pieces.h"

#include <algorithm>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/data/indices.h"

namespace terrazzo::segment {

std::vector<Piece> measure_pieces(const std::vector<std::int32_t>& raster, int width, int height) {
  const std::int32_t n = raster.empty() ? 0 : std::max(0, *std::max_element(raster.begin(), raster.end()));
  std::vector<Piece> pieces(n);
  std::vector<std::vector<Vec2>> ends(n);  // corners of the first and last pixel of each row's run
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = pixel_at(x, y, width);
      const std::int32_t id = raster[i];
      if (id == 0) continue;
      Piece& p = pieces[id - 1];
      if (p.area == 0) {
        p.left = x;
        p.right = x;
        p.top = y;
      }
      p.area += 1;
      p.left = std::min(p.left, x);
      p.right = std::max(p.right, x);
      p.bottom = y;
      auto side = [&](bool inside, std::size_t j) {
        if (!inside)
          p.at_border += 1;
        else if (raster[j] == 0)
          p.outline += 1;
        else if (raster[j] != id)
          p.contact += 1;
      };
      side(x > 0, i - 1);
      side(x + 1 < width, i + 1);
      side(y > 0, i - width);
      side(y + 1 < height, i + width);
      if (x == 0 || raster[i - 1] != id) ends[id - 1].emplace_back(x, y), ends[id - 1].emplace_back(x, y + 1);
      if (x + 1 == width || raster[i + 1] != id)
        ends[id - 1].emplace_back(x + 1, y), ends[id - 1].emplace_back(x + 1, y + 1);
    }
  for (std::int32_t k = 0; k < n; ++k) pieces[k].hull_area = hull_area(std::move(ends[k]));
  return pieces;
}

}  // namespace terrazzo::segment
