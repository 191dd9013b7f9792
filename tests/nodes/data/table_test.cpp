#include "nodes/data/table.h"

#include <gtest/gtest.h>

namespace terrazzo {
namespace {

TEST(Table, ARenamedColumnIsFoundByEitherName) {
  const Table now{{"name", "accuracy %"}, {{std::string("ball"), 75.0}}};
  const Table then{{"name", "told %"}, {{std::string("ball"), 60.0}}};
  EXPECT_EQ(now.number(0, "told %"), 75);
  EXPECT_EQ(then.number(0, "accuracy %"), 60);
  EXPECT_EQ(now.column("told by"), -1);
  EXPECT_THROW(now.number(0, "main feature"), Error);
}

}  // namespace
}  // namespace terrazzo
