#include "nodes/common/geometry/components.h"

#include <map>

#include "nodes/common/geometry/disjoint_sets.h"

namespace terrazzo {

Components connected_components(const std::vector<std::int32_t>& raster, int width, int height,
                                bool diagonal) {
  Components out;
  DisjointSets sets(raster.size());  // each is represented by its first pixel
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::int32_t i = y * width + x, v = raster[i];
      if (v == 0) continue;
      if (x > 0 && raster[i - 1] == v) sets.join(i, i - 1);
      if (y == 0) continue;
      if (raster[i - width] == v) sets.join(i, i - width);
      if (diagonal && x > 0 && raster[i - width - 1] == v) sets.join(i, i - width - 1);
      if (diagonal && x + 1 < width && raster[i - width + 1] == v) sets.join(i, i - width + 1);
    }
  out.ids.assign(raster.size(), 0);
  for (std::size_t i = 0; i < raster.size(); ++i) {
    if (raster[i] == 0) continue;
    const std::size_t r = sets.find(static_cast<std::int32_t>(i));
    if (r == i) {
      out.values.push_back(raster[i]);
      out.sizes.push_back(0);
      out.ids[i] = out.count();
    } else {
      out.ids[i] = out.ids[r];
    }
    ++out.sizes[out.ids[i] - 1];
  }
  return out;
}

void renumber_labels(std::vector<std::int32_t>& labels) {
  std::map<std::int32_t, std::int32_t> number;
  for (auto& l : labels)
    if (l != 0) l = number.emplace(l, static_cast<std::int32_t>(number.size()) + 1).first->second;
}

}  // namespace terrazzo
