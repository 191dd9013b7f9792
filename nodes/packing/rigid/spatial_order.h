// Orders points so that neighbors in space are close in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::packing {

// Smaller numbers of particles fit the cache in any order, so their order is not changed.
inline constexpr std::size_t kCached = 50000;

// The points' indices along a Morton curve through [0, box), 1024 cells per edge; ties are ordered by index.
std::vector<std::int32_t> spatial_order(const Vec3& box, const std::vector<Vec3>& points);

// v[k] becomes v[order[k]].
template <class T>
void reorder(std::vector<T>& v, const std::vector<std::int32_t>& order) {
  if (v.empty()) return;
  std::vector<T> out;
  out.reserve(order.size());
  for (const std::int32_t i : order) out.push_back(v[i]);
  v = std::move(out);
}

}  // namespace terrazzo::packing
