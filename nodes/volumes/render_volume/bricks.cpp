#include "nodes/volumes/render_volume/bricks.h"

#include <algorithm>
#include <array>

#include "nodes/data/indices.h"

namespace terrazzo::render_volume {
namespace {

// Whether any density between two stored values belongs to a tissue.
bool any_visible(const DensityIntervals& intervals, const ScanField& scan, std::uint16_t low,
                 std::uint16_t high) {
  const float a = scan.low + scan.step * low, b = scan.low + scan.step * high;
  for (std::size_t k = 0; k < intervals.tissue.size(); ++k) {
    if (intervals.tissue[k] < 0) continue;
    const bool below = k > 0 && b < intervals.edges[k - 1];
    const bool beyond = k < intervals.edges.size() && a >= intervals.edges[k];
    if (!below && !beyond) return true;
  }
  return false;
}

}  // namespace

Bricks::Bricks(const ScanField& scan, const DensityIntervals& intervals, const Work& work) {
  // Cells from 0 to size: one before the first voxel's center, one after the last's.
  count_ = (scan.size.array() + 1 + kCells - 1) / kCells;
  const std::size_t total = voxels_in(count_);
  distance_.assign(total, 255);
  place_.assign(total, -1);
  const auto each = [&](const auto& body) {
    work.parallel(total, 64, [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) {
        const int i = b;
        body(b, Vec3i(i % count_.x(), i / count_.x() % count_.y(), i / count_.x() / count_.y()));
      }
    });
  };
  const auto voxel = [&](int x, int y, int z) {
    return scan.voxels[(static_cast<std::size_t>(std::clamp(z, 0, scan.size.z() - 1)) * scan.size.y() +
                        std::clamp(y, 0, scan.size.y() - 1)) *
                           scan.size.x() +
                       std::clamp(x, 0, scan.size.x() - 1)];
  };
  each([&](std::size_t b, const Vec3i& at) {
    std::uint16_t low = 65535, high = 0;
    const Vec3i first = at * kCells - Vec3i::Ones();  // voxel at a brick's first corner
    for (int z = 0; z <= kCells; ++z)
      for (int y = 0; y <= kCells; ++y)
        for (int x = 0; x <= kCells; ++x) {
          const auto v = voxel(first.x() + x, first.y() + y, first.z() + z);
          low = std::min(low, v);
          high = std::max(high, v);
        }
    if (any_visible(intervals, scan, low, high)) distance_[b] = 0;
  });

  std::size_t visible = 0;
  for (const auto d : distance_) visible += d == 0;
  visible_share_ = static_cast<double>(visible) / total;

  // Chessboard distances, exact in two passes over thirteen neighbors each.
  const auto pass = [&](int sign) {
    const auto [nx, ny, nz] = std::array{count_.x(), count_.y(), count_.z()};
    for (int c = 0; c < nz; ++c)
      for (int b = 0; b < ny; ++b)
        for (int a = 0; a < nx; ++a) {
          const int x = sign > 0 ? a : nx - 1 - a, y = sign > 0 ? b : ny - 1 - b,
                    z = sign > 0 ? c : nz - 1 - c;
          std::uint8_t& d = distance_[index(x, y, z)];
          for (int k = 0; k < 13; ++k) {
            const int u = x + sign * (k % 3 - 1), v = y + sign * (k / 3 % 3 - 1), w = z + sign * (k / 9 - 1);
            if (u < 0 || v < 0 || w < 0 || u >= nx || v >= ny || w >= nz) continue;
            d = std::min<int>(d, std::min(254, int(distance_[index(u, v, w)])) + 1);
          }
        }
  };
  pass(1);
  pass(-1);

  std::int32_t stored = 0;
  for (std::size_t b = 0; b < total; ++b)
    if (distance_[b] <= 1) place_[b] = stored++;
  stored_.resize(static_cast<std::size_t>(stored) * kVoxels +
                 1);  // one more, because voxels are read in pairs
  each([&](std::size_t b, const Vec3i& at) {
    if (place_[b] < 0) return;
    std::uint16_t* out = stored_.data() + static_cast<std::size_t>(place_[b]) * kVoxels;
    const Vec3i first = at * kCells - Vec3i::Constant(2);
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) *out++ = voxel(first.x() + x, first.y() + y, first.z() + z);
  });
}

}  // namespace terrazzo::render_volume
