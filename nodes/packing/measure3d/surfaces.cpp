#include "nodes/packing/measure3d/surfaces.h"

#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>

#include "nodes/packing/measure3d/directions13.h"

namespace terrazzo::measure3d {
namespace {

using Counts = std::array<std::uint32_t, kDirectionCount>;
using Crossings = std::unordered_map<std::uint64_t, Counts>;  // key: smaller label · 2³² + larger label

// Counts where labels that are not negative meet, from the planes begin to end − 1.
template <class Label>
Crossings count_crossings(const VoxelBox& box, const Label* ids, int begin, int end) {
  const Vec3i& n = box.size;
  Crossings part;
  for (int z = begin; z < end; ++z)
    for (std::size_t d = 0; d < kDirectionCount; ++d) {
      const int* step = kSteps[d];
      int z2 = z + step[2];
      if (z2 >= n.z() && !box.periodic) continue;
      z2 %= n.z();
      for (int y = 0; y < n.y(); ++y) {
        int y2 = y + step[1];
        if (!box.periodic && (y2 < 0 || y2 >= n.y())) continue;
        y2 = (y2 + n.y()) % n.y();
        const std::size_t row = voxel_at(0, y, z, n), row2 = voxel_at(0, y2, z2, n);
        for (int x = 0; x < n.x(); ++x) {
          int x2 = x + step[0];
          if (x2 < 0 || x2 >= n.x()) {
            if (!box.periodic) continue;
            x2 = x2 < 0 ? n.x() - 1 : 0;
          }
          const std::size_t i = row + x, j = row2 + x2;
          const std::int32_t a = ids[i], b = ids[j];
          if (a == b || a < 0 || b < 0) continue;
          ++part[static_cast<std::uint64_t>(std::min(a, b)) << 32 |
                 static_cast<std::uint32_t>(std::max(a, b))][d];
        }
      }
    }
  return part;
}

template <class Label>
Crossings all_crossings(const VoxelBox& box, const Label* ids, const Work& work) {
  return work.reduce<Crossings>(
      box.size.z(), 4, {},
      [&](std::size_t begin, std::size_t end) { return count_crossings(box, ids, begin, end); },
      [](Crossings a, const Crossings& b) {
        for (const auto& [key, counts] : b)
          for (std::size_t d = 0; d < kDirectionCount; ++d) a[key][d] += counts[d];
        return a;
      });
}

using Areas = std::array<double, kDirectionCount>;

// A crossing stands for an area of (voxel volume / step length), and an area is seen from each direction
// with half of itself on average.
Areas crossing_areas(const Vec3& spacing) {
  std::array<Vec3, kDirectionCount> steps;
  for (std::size_t d = 0; d < kDirectionCount; ++d) steps[d] = step_of(d, spacing);
  Areas area = direction_shares(steps);
  for (std::size_t d = 0; d < kDirectionCount; ++d) area[d] *= 2 * spacing.prod() / steps[d].norm();
  return area;
}

// How many times more pairs of voxels there are by direction than inside the box.
Areas missing_pairs(const VoxelBox& box) {
  Areas out;
  out.fill(1);
  for (std::size_t d = 0; d < kDirectionCount; ++d)
    for (int a = 0; a < 3; ++a)
      if (!box.periodic && kSteps[d][a] != 0 && box.size[a] > 1) out[d] *= box.size[a] / (box.size[a] - 1.0);
  return out;
}

// Calls visit(smaller label, larger label, counts) for labels that share faces, in order.
template <class Visit>
void visit_pairs(const Crossings& all, Visit&& visit) {
  for (const auto& [key, counts] : std::map<std::uint64_t, Counts>(all.begin(), all.end())) {
    if (std::all_of(counts.begin(), counts.begin() + kFaceDirections, [](auto c) { return c == 0; }))
      continue;
    visit(static_cast<std::int32_t>(key >> 32), static_cast<std::int32_t>(key & 0xffffffffu), counts);
  }
}

}  // namespace

std::vector<Touch> touches_of(const Raster& raster, const Work& work) {
  std::vector<Touch> out;
  if (raster.ids.empty()) return out;
  const Crossings all = all_crossings(raster.box, raster.ids.data(), work);
  const Areas area = crossing_areas(raster.box.spacing);
  visit_pairs(all, [&](std::int32_t a, std::int32_t b, const Counts& counts) {
    Touch& t = out.emplace_back(Touch{a, b, 0});
    for (std::size_t d = 0; d < kDirectionCount; ++d) t.area += area[d] * counts[d];
  });
  return out;
}

std::vector<Interface> interfaces_of(const Classes& classes, const Work& work) {
  const Crossings all = all_crossings(classes.box, classes.of.data(), work);
  const Areas area = crossing_areas(classes.box.spacing), missing = missing_pairs(classes.box);
  const double volume = classes.of.size() * classes.voxel_volume();
  std::vector<Interface> out;
  visit_pairs(all, [&](std::int32_t a, std::int32_t b, const Counts& counts) {
    Interface& t = out.emplace_back(Interface{a, b, 0, 0});
    for (std::size_t d = 0; d < kDirectionCount; ++d) {
      t.area += area[d] * counts[d];
      t.per_volume += area[d] * counts[d] * missing[d] / volume;
    }
  });
  return out;
}

}  // namespace terrazzo::measure3d
