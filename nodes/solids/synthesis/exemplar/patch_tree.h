// Nearest neighbors among patches by a k-d tree.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace terrazzo::solids {

// Bentley's k-d tree with the incremental distances of Arya and Mount 1993. The points must outlive the tree.
class PatchTree {
 public:
  struct Hit {
    float distance2;
    std::uint32_t item;
    bool operator<(const Hit& o) const {
      return distance2 != o.distance2 ? distance2 < o.distance2 : item < o.item;
    }
  };

  // Point of item i is at points[i·dims].
  PatchTree(const float* points, int dims, std::vector<std::uint32_t> items);

  // The k nearest points that `admit` accepts, by rising distance. None is farther than (1 + epsilon) times
  // the true one of its rank, unless the search ends after `most_leaves` leaves.
  template <class Admit>
  void nearest(const float* query, std::size_t k, float epsilon, int most_leaves, Admit&& admit,
               std::vector<Hit>& hits) const {
    hits.clear();
    std::array<float, kMostDims> offset{};
    Search<Admit> s{query, k, (1 + epsilon) * (1 + epsilon), most_leaves, admit, hits, offset};
    descend(s, 0, 0.0f);
  }

  static constexpr int kMostDims = 192;

 private:
  struct Node {
    int axis = -1;  // −1: a leaf of items [first, last)
    float split = 0;
    std::uint32_t first = 0, last = 0, right = 0;  // the left child follows its parent
  };
  template <class Admit>
  struct Search {
    const float* query;
    std::size_t k;
    float slack;
    int leaves;
    Admit& admit;
    std::vector<Hit>& hits;
    std::array<float, kMostDims>& offset;
  };

  void build(std::size_t first, std::size_t last);

  template <class Admit>
  void descend(Search<Admit>& s, std::size_t at, float bound) const {
    const Node& n = nodes_[at];
    if (n.axis < 0) {
      --s.leaves;
      for (std::size_t i = n.first; i < n.last; ++i) offer(s, items_[i]);
      return;
    }
    const float d = s.query[n.axis] - n.split;
    const std::size_t left = at + 1, right = n.right;
    descend(s, d < 0 ? left : right, bound);
    if (s.leaves <= 0) return;
    float& old = s.offset[n.axis];
    const float kept = old, further = bound - kept * kept + d * d;
    if (s.hits.size() == s.k && further * s.slack >= s.hits.back().distance2) return;
    old = d;
    descend(s, d < 0 ? right : left, further);
    old = kept;
  }

  template <class Admit>
  void offer(Search<Admit>& s, std::uint32_t item) const {
    const float limit =
        s.hits.size() == s.k ? s.hits.back().distance2 : std::numeric_limits<float>::infinity();
    const float* p = points_ + static_cast<std::size_t>(item) * static_cast<std::size_t>(dims_);
    float sum = 0;
    for (int d = 0; d < dims_; d += 8) {
      float part = 0;
      for (int j = d; j < d + 8; ++j) part += (p[j] - s.query[j]) * (p[j] - s.query[j]);
      if ((sum += part) > limit) return;
    }
    const Hit h{sum, item};
    if (s.hits.size() == s.k && !(h < s.hits.back())) return;
    if (!s.admit(item)) return;
    if (s.hits.size() == s.k) s.hits.pop_back();
    s.hits.insert(std::upper_bound(s.hits.begin(), s.hits.end(), h), h);
  }

  const float* points_;
  int dims_;
  std::vector<std::uint32_t> items_;
  std::vector<Node> nodes_;
};

}  // namespace terrazzo::solids
