#include "runtime/threads/arena.h"

#include <gtest/gtest.h>

#include <optional>

namespace terrazzo {
namespace {

TEST(Arena, IsReusedWhenItIsIdle) {
  std::optional<Arena> first(std::in_place, 3);
  tbb::task_arena* const of_first = first->operator->();
  EXPECT_EQ(of_first->max_concurrency(), 3);
  Arena second(3), other(2);
  EXPECT_NE(second.operator->(), of_first);  // in use
  EXPECT_EQ(other->max_concurrency(), 2);
  first.reset();
  Arena third(3);
  EXPECT_EQ(third.operator->(), of_first);
}

}  // namespace
}  // namespace terrazzo
