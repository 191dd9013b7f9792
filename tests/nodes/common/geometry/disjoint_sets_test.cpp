#include "nodes/common/geometry/disjoint_sets.h"

#include <gtest/gtest.h>

#include "runtime/random.h"

namespace terrazzo {
namespace {

TEST(DisjointSets, AgreeWithLabelsAndAreRepresentedBySmallest) {
  constexpr std::int32_t kCount = 60;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random r(seed);
    DisjointSets sets(kCount);
    std::vector<std::int32_t> label(kCount);
    for (std::int32_t i = 0; i < kCount; ++i) label[i] = i;
    for (int k = 0; k < 45; ++k) {
      const auto a = static_cast<std::int32_t>(r.below(kCount)),
                 b = static_cast<std::int32_t>(r.below(kCount));
      sets.join(a, b);
      const std::int32_t high = std::max(label[a], label[b]), low = std::min(label[a], label[b]);
      for (auto& l : label)
        if (l == high) l = low;
    }
    for (std::int32_t i = 0; i < kCount; ++i) EXPECT_EQ(sets.find(i), label[i]) << seed;
  }
}

TEST(DisjointSets, KeepTheRepresentativeThatIsChosen) {
  DisjointSets sets;
  for (std::int32_t i = 0; i < 4; ++i) EXPECT_EQ(sets.add(), i);
  sets.join_to(3, 1);
  sets.join_to(3, 0);
  EXPECT_EQ(sets.find(0), 3);
  EXPECT_EQ(sets.find(1), 3);
  EXPECT_EQ(sets.find(2), 2);
  for (std::int32_t i : {0, 1, 3}) sets.reset(i);
  for (std::int32_t i = 0; i < 4; ++i) EXPECT_EQ(sets.find(i), i);
}

}  // namespace
}  // namespace terrazzo
