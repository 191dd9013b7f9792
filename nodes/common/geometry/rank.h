// Medians and other order statistics.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace terrazzo {

// The element at index `rank` < v.size() of the sorted `v`. Reorders v.
template <class T>
T at_rank(std::vector<T>& v, std::size_t rank) {
  const auto at = v.begin() + rank;
  std::nth_element(v.begin(), at, v.end());
  return *at;
}

// The upper one of two middle elements. `v` must not be empty.
template <class T>
T median(std::vector<T> v) {
  return at_rank(v, v.size() / 2);
}

}  // namespace terrazzo
