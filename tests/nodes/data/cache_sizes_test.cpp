#include <gtest/gtest.h>

#include <Eigen/Core>

namespace terrazzo {
namespace {

// The order of sums in products of large matrices follows these sizes, so they must not be the processor's.
TEST(CacheSizes, DoNotDependOnTheProcessor) {
  EXPECT_EQ(Eigen::l1CacheSize(), 32 << 10);
  EXPECT_EQ(Eigen::l2CacheSize(), 512 << 10);
  EXPECT_EQ(Eigen::l3CacheSize(), 8 << 20);
}

}  // namespace
}  // namespace terrazzo
