#include "nodes/common/geometry/rank.h"

#include <gtest/gtest.h>

#include "runtime/random.h"

namespace terrazzo {
namespace {

TEST(Rank, IsThatOfTheSortedElements) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random r(seed);
    std::vector<int> v;
    for (std::size_t n = 1 + r.below(30); v.size() < n;) v.push_back(static_cast<int>(r.below(12)));
    std::vector<int> sorted = v;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(median(v), sorted[v.size() / 2]);
    for (std::size_t k = 0; k < v.size(); ++k) EXPECT_EQ(at_rank(v, k), sorted[k]);
  }
}

}  // namespace
}  // namespace terrazzo
