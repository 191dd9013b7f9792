#include "nodes/packing/measure3d/surfaces.h"

#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>

#include "nodes/common/geometry/directions.h"

namespace terrazzo::measure3d {
namespace {

constexpr std::size_t kDirectionCount = 13;
constexpr int kSteps[kDirectionCount][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},  {1, 1, 0},  {1, -1, 0},
                                            {1, 0, 1},  {-1, 0, 1}, {0, 1, 1},  {0, -1, 1}, {1, 1, 1},
                                            {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1}};
constexpr std::size_t kFaceDirections = 3;  // the first ones cross voxel faces

Vec3 step_of(std::size_t d, const Vec3& spacing) {
  return Vec3(kSteps[d][0], kSteps[d][1], kSteps[d][2]).cwiseProduct(spacing);
}

// Share of all directions that are closest to each of the 13.
std::array<double, kDirectionCount> direction_weights(const Vec3& spacing) {
  constexpr std::size_t kSamples = 60000;
  std::array<double, kDirectionCount> weight{};
  for (std::size_t i = 0; i < kSamples; ++i) {
    const Vec3 u = half_sphere_direction(i, kSamples);
    std::size_t best = 0;
    double most = -1;
    for (std::size_t d = 0; d < kDirectionCount; ++d)
      if (const double c = std::abs(u.dot(step_of(d, spacing).normalized())); c > most) {
        most = c;
        best = d;
      }
    weight[best] += 1.0 / kSamples;
  }
  return weight;
}

using Counts = std::array<std::uint32_t, kDirectionCount>;
struct Crossings {
  std::array<std::uint64_t, kDirectionCount> phase{};
  std::unordered_map<std::uint64_t, Counts> pairs;  // key: smaller label · 2³² + larger label
};

}  // namespace

VoxelSurfaces voxel_surfaces(const Raster& raster, const Work& work) {
  const Vec3i& n = raster.box.size;
  const bool wraps = raster.box.periodic, labels = !raster.ids.empty();
  const Crossings all = work.reduce<Crossings>(
      n.z(), 4, {},
      [&](std::size_t begin, std::size_t end) {
        Crossings part;
        for (int z = begin; z < static_cast<int>(end); ++z) {
          work.check();
          for (std::size_t d = 0; d < kDirectionCount; ++d) {
            const int* step = kSteps[d];
            int z2 = z + step[2];
            if (z2 >= n.z() && !wraps) continue;
            z2 %= n.z();
            for (int y = 0; y < n.y(); ++y) {
              int y2 = y + step[1];
              if (!wraps && (y2 < 0 || y2 >= n.y())) continue;
              y2 = (y2 + n.y()) % n.y();
              const std::size_t row = raster.index(0, y, z), row2 = raster.index(0, y2, z2);
              for (int x = 0; x < n.x(); ++x) {
                int x2 = x + step[0];
                if (x2 < 0 || x2 >= n.x()) {
                  if (!wraps) continue;
                  x2 = x2 < 0 ? n.x() - 1 : 0;
                }
                const std::size_t i = row + x, j = row2 + x2;
                part.phase[d] += raster.in[i] != raster.in[j];
                if (!labels) continue;
                const std::int32_t a = raster.ids[i], b = raster.ids[j];
                if (a == b || a < 0 || b < 0) continue;
                ++part.pairs[static_cast<std::uint64_t>(std::min(a, b)) << 32 |
                             static_cast<std::uint32_t>(std::max(a, b))][d];
              }
            }
          }
        }
        return part;
      },
      [](Crossings a, const Crossings& b) {
        for (std::size_t d = 0; d < kDirectionCount; ++d) a.phase[d] += b.phase[d];
        for (const auto& [key, counts] : b.pairs)
          for (std::size_t d = 0; d < kDirectionCount; ++d) a.pairs[key][d] += counts[d];
        return a;
      });
  // A crossing stands for an area of (voxel volume / step length), and an area is seen from each direction
  // with half of itself on average.
  std::array<double, kDirectionCount> area = direction_weights(raster.box.spacing);
  for (std::size_t d = 0; d < kDirectionCount; ++d)
    area[d] *= 2 * raster.voxel_volume() / step_of(d, raster.box.spacing).norm();
  VoxelSurfaces out;
  for (std::size_t d = 0; d < kDirectionCount; ++d) out.phase += area[d] * all.phase[d];
  for (const auto& [key, counts] : std::map<std::uint64_t, Counts>(all.pairs.begin(), all.pairs.end())) {
    if (std::all_of(counts.begin(), counts.begin() + kFaceDirections, [](auto c) { return c == 0; }))
      continue;
    Touch t{static_cast<std::int32_t>(key >> 32), static_cast<std::int32_t>(key & 0xffffffffu), 0};
    for (std::size_t d = 0; d < kDirectionCount; ++d) t.area += area[d] * counts[d];
    out.touches.push_back(t);
  }
  return out;
}

}  // namespace terrazzo::measure3d
