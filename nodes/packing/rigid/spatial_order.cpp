#include "nodes/packing/rigid/spatial_order.h"

#include <algorithm>

namespace terrazzo::packing {
namespace {

// Spreads ten bits, with two zeros between each.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ff;
  x = (x | x << 8) & 0x0300f00f;
  x = (x | x << 4) & 0x030c30c3;
  return (x | x << 2) & 0x09249249;
}

}  // namespace

std::vector<std::int32_t> spatial_order(const Vec3& box, const std::vector<Vec3>& points) {
  std::vector<std::pair<std::uint32_t, std::int32_t>> key;
  key.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::uint32_t code = 0;
    for (int a = 0; a < 3; ++a)
      code |= spread(static_cast<std::uint32_t>(std::clamp(points[i][a] / box[a] * 1024, 0.0, 1023.0))) << a;
    key.emplace_back(code, static_cast<std::int32_t>(i));
  }
  std::sort(key.begin(), key.end());
  std::vector<std::int32_t> order;
  order.reserve(key.size());
  for (const auto& k : key) order.push_back(k.second);
  return order;
}

}  // namespace terrazzo::packing
