#include "nodes/solids/synthesis/exemplar/patch_tree.h"

namespace terrazzo::solids {

PatchTree::PatchTree(const float* points, int dims, std::vector<std::uint32_t> items)
    : points_(points), dims_(dims), items_(std::move(items)) {
  build(0, items_.size());
}

// Splits at the median along the axis of the widest spread.
void PatchTree::build(std::size_t first, std::size_t last) {
  constexpr std::size_t kLeaf = 8;
  const std::size_t at = nodes_.size();
  nodes_.emplace_back();
  nodes_[at].first = first;
  nodes_[at].last = last;
  const auto value = [&](std::uint32_t item, int d) {
    return points_[static_cast<std::size_t>(item) * static_cast<std::size_t>(dims_) + d];
  };
  if (last - first <= kLeaf) return;
  int axis = 0;
  float widest = 0;
  const std::size_t step = std::max<std::size_t>(1, (last - first) / 256);  // sample the spread
  for (int d = 0; d < dims_; ++d) {
    float lo = value(items_[first], d), hi = lo;
    for (std::size_t i = first; i < last; i += step) {
      lo = std::min(lo, value(items_[i], d));
      hi = std::max(hi, value(items_[i], d));
    }
    if (hi - lo > widest) {
      widest = hi - lo;
      axis = d;
    }
  }
  if (widest <= 0) return;  // all equal: one leaf
  const std::size_t middle = first + (last - first) / 2;
  std::nth_element(items_.begin() + first, items_.begin() + middle, items_.begin() + last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const float x = value(a, axis), y = value(b, axis);
                     return x != y ? x < y : a < b;
                   });
  nodes_[at].axis = axis;
  nodes_[at].split = value(items_[middle], axis);
  build(first, middle);
  nodes_[at].right = nodes_.size();
  build(middle, last);
}

}  // namespace terrazzo::solids
