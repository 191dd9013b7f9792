#include "nodes/common/geometry/grid/runs.h"

#include <numeric>

namespace terrazzo {

std::size_t VoxelRuns::root(std::size_t k) {
  while (parent_[k] != k) {
    const std::size_t up = parent_[k];
    for (std::size_t a = 0; a < 3; ++a) offset_[k][a] += offset_[up][a];  // that of a root is zero
    k = parent_[k] = parent_[up];
  }
  return k;
}

std::vector<std::uint8_t> VoxelRuns::reach(const Work& work) {
  if (wraps_) return winding_;
  std::vector<std::uint8_t> low(runs.size(), 0), high(runs.size(), 0);
  for (std::size_t row = 0; row + 1 < row_begin.size(); ++row) {
    if (row % 4096 == 0) work.check();
    const int y = row % size_.y(), z = row / size_.y();
    for (std::size_t k = row_begin[row]; k < row_begin[row + 1]; ++k) {
      const std::size_t piece = root(k);
      low[piece] |= (runs[k].begin == 0) | (y == 0) << 1 | (z == 0) << 2;
      high[piece] |= (runs[k].end == size_.x()) | (y == size_.y() - 1) << 1 | (z == size_.z() - 1) << 2;
    }
  }
  for (std::size_t k = 0; k < low.size(); ++k) low[k] &= high[k];
  return low;
}

void VoxelRuns::join(const Work& work) {
  parent_.resize(runs.size());
  std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  offset_.assign(runs.size(), {});
  winding_.assign(runs.size(), 0);
  for (int z = 0; z < size_.z(); ++z) {
    work.check();
    const bool last_z = z + 1 == size_.z();
    for (int y = 0; y < size_.y(); ++y) {
      const bool last_y = y + 1 == size_.y();
      if (wraps_) join_ends(row(y, z));
      if (!last_y || wraps_) join_rows(row(y, z), row(last_y ? 0 : y + 1, z), {0, last_y, 0});
      if (!last_z || wraps_) join_rows(row(y, z), row(y, last_z ? 0 : z + 1), {0, 0, last_z});
    }
  }
}

void VoxelRuns::join_ends(std::size_t r) {
  if (row_begin[r] == row_begin[r + 1]) return;
  const std::size_t a = row_begin[r], b = row_begin[r + 1] - 1;
  if (runs[a].begin == 0 && runs[b].end == size_.x() && runs[a].label == runs[b].label)
    unite(b, a, {1, 0, 0});
}

void VoxelRuns::join_rows(std::size_t r, std::size_t s, const Periods& step) {
  std::size_t a = row_begin[r], b = row_begin[s];
  while (a < row_begin[r + 1] && b < row_begin[s + 1]) {
    const bool overlap = runs[a].begin < runs[b].end && runs[b].begin < runs[a].end;
    if (overlap && runs[a].label == runs[b].label) unite(a, b, step);
    ++(runs[a].end < runs[b].end ? a : b);
  }
}

// The root is the first run, so that pieces have an order.
void VoxelRuns::unite(std::size_t a, std::size_t b, const Periods& step) {
  // From the root to k.
  const auto offset_from = [&](std::size_t k) {
    Periods sum{};
    for (; parent_[k] != k; k = parent_[k])
      for (std::size_t i = 0; i < 3; ++i) sum[i] += offset_[k][i];
    return sum;
  };
  std::size_t from = root(a), to = root(b);
  Periods way = step;  // from one root to the other
  const Periods first = offset_from(a), second = offset_from(b);
  for (std::size_t i = 0; i < 3; ++i) way[i] += first[i] - second[i];
  if (from == to) {
    for (std::size_t i = 0; i < 3; ++i) winding_[from] |= (way[i] != 0) << i;
    return;
  }
  if (from > to) {
    std::swap(from, to);
    for (auto& w : way) w = -w;
  }
  parent_[to] = from;
  offset_[to] = way;
  winding_[from] |= winding_[to];
}

}  // namespace terrazzo
