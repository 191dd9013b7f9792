#include "nodes/photograph/segment/color/split.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/geometry/disjoint_sets.h"
#include "nodes/data/indices.h"
#include "nodes/photograph/segment/neighbors.h"

namespace terrazzo::segment {
namespace {

// Lower envelope of the parabolas f[q] + (p − q)² along one line.
void transform_line(const float* f, float* out, int n, std::vector<int>& v, std::vector<float>& z) {
  v.resize(n);
  z.resize(n + 1);
  int k = 0;
  v[0] = 0;
  z[0] = -std::numeric_limits<float>::infinity();
  z[1] = std::numeric_limits<float>::infinity();
  for (int q = 1; q < n; ++q) {
    auto meet = [&](int p) {
      return ((f[q] + static_cast<float>(q) * q) - (f[p] + static_cast<float>(p) * p)) / (2.0f * (q - p));
    };
    float s = meet(v[k]);
    while (k > 0 && s <= z[k]) s = meet(v[--k]);
    if (s <= z[k]) s = z[k];
    v[++k] = q;
    z[k] = s;
    z[k + 1] = std::numeric_limits<float>::infinity();
  }
  k = 0;
  for (int q = 0; q < n; ++q) {
    while (z[k + 1] < q) ++k;
    const float d = q - v[k];
    out[q] = f[v[k]] + d * d;
  }
}

}  // namespace

std::vector<float> squared_distance(const std::vector<std::int32_t>& raster, int width, int height,
                                    bool border_is_outside, const Work& work) {
  // First count the distance to the nearest change of value along each column, then transform each run of
  // equal values along the rows.
  const float far = 1e12f;
  std::vector<float> down(raster.size(), far), out(raster.size(), 0);
  work.parallel(width, 64, [&](std::size_t b, std::size_t e) {
    for (int x = b; x < static_cast<int>(e); ++x) {
      float d = border_is_outside ? 0 : 1e6f;
      for (int y = 0; y < height; ++y) {
        const std::size_t i = pixel_at(x, y, width);
        d = y > 0 && raster[i] != raster[i - width] ? 1 : d + 1;
        down[i] = d * d;
      }
      d = border_is_outside ? 0 : 1e6f;
      for (int y = height - 1; y >= 0; --y) {
        const std::size_t i = pixel_at(x, y, width);
        d = y + 1 < height && raster[i] != raster[i + width] ? 1 : d + 1;
        down[i] = std::min(down[i], d * d);
      }
    }
  });
  work.parallel(height, 64, [&](std::size_t b, std::size_t e) {
    std::vector<float> f, g, z;
    std::vector<int> v;
    for (std::size_t y = b; y < e; ++y)
      for (int x = 0; x < width;) {
        const std::size_t row = y * width;
        int end = x + 1;
        while (end < width && raster[row + end] == raster[row + x]) ++end;
        if (raster[row + x] != 0) {
          // Each end of a run is a wall of distance zero, except at the border if that is not outside.
          const bool left = x > 0 || border_is_outside, right = end < width || border_is_outside;
          f.assign(1, left ? 0.0f : far);
          for (int i = x; i < end; ++i) f.push_back(down[row + i]);
          f.push_back(right ? 0.0f : far);
          g.resize(f.size());
          transform_line(f.data(), g.data(), f.size(), v, z);
          std::copy(g.begin() + 1, g.end() - 1, out.begin() + row + x);
        }
        x = end;
      }
  });
  return out;
}

std::vector<std::int32_t> split_at_necks(const std::vector<std::int32_t>& raster, int width, int height,
                                         double strength, const Work& work) {
  const auto distance2 = squared_distance(raster, width, height, false, work);
  std::vector<std::int32_t> order;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(raster.size()); ++i)
    if (raster[i] != 0) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return distance2[a] != distance2[b] ? distance2[a] > distance2[b] : a < b;
  });
  work.check();

  // Basins grow from their summits down. Where two basins meet, the meeting pixel is their neck.
  const double widest = std::sqrt(std::clamp(strength, 0.0, 1.0));
  DisjointSets basins;
  std::vector<float> summit;
  std::vector<std::int32_t> basin(raster.size(), -1);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k % 65536 == 0) work.check();
    const std::int32_t i = order[k];
    const float here = std::sqrt(distance2[i]);
    std::int32_t highest = -1;
    std::int32_t met[4];
    int count = 0;
    auto visit = [&](std::int32_t j) {
      if (basin[j] < 0 || raster[j] != raster[i]) return;
      if (highest < 0 || distance2[j] > distance2[highest]) highest = j;
      met[count++] = basins.find(basin[j]);
    };
    neighbors(i, width, height, visit);
    if (highest < 0) {
      basin[i] = basins.add();
      summit.push_back(here);
      continue;
    }
    basin[i] = basin[highest];
    for (int n = 0; n < count; ++n) {
      std::int32_t a = basins.find(basin[i]), b = basins.find(met[n]);
      if (a == b) continue;
      const float lower = std::min(summit[a], summit[b]);
      if (lower - here < 1 || here >= widest * lower) {
        if (summit[a] < summit[b] || (summit[a] == summit[b] && a > b)) std::swap(a, b);
        basins.join_to(a, b);
      }
    }
  }
  std::vector<std::int32_t> number(basins.count(), 0), out(raster.size(), 0);
  std::int32_t pieces = 0;
  for (std::size_t i = 0; i < raster.size(); ++i) {
    if (raster[i] == 0) continue;
    auto& n = number[basins.find(basin[i])];
    if (n == 0) n = ++pieces;
    out[i] = n;
  }
  return out;
}

}  // namespace terrazzo::segment
