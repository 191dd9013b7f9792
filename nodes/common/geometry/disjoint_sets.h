// Disjoint sets of the numbers 0 … n − 1 (union-find with path halving: Tarjan, van Leeuwen 1984).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace terrazzo {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count = 0) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  std::size_t count() const { return parent_.size(); }  // of numbers

  // Adds the set of the next number, and returns the number.
  std::int32_t add() { return parent_.emplace_back(static_cast<std::int32_t>(parent_.size())); }

  // The number that represents the set of i.
  std::int32_t find(std::int32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  // Joins two sets. The smaller of their representatives becomes that of both.
  void join(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  // Joins two different sets, of which `kept` and `other` are the representatives. `kept` becomes that of
  // both.
  void join_to(std::int32_t kept, std::int32_t other) { parent_[other] = kept; }

  // Makes i a set of its own again. Only for resetting all members of a set.
  void reset(std::int32_t i) { parent_[i] = i; }

 private:
  std::vector<std::int32_t> parent_;
};

}  // namespace terrazzo
