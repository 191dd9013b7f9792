#include <gtest/gtest.h>

#include "runtime/clients/cli/slurm/slurm.h"
#include "tests/support/code_of.h"

namespace terrazzo::cli {
namespace {
using Words = std::vector<std::string>;

TEST(SlurmWords, AreSplitAsAShellDoes) {
  EXPECT_EQ(slurm::words("--mem=8G  --qos=a"), (Words{"--mem=8G", "--qos=a"}));
  EXPECT_EQ(slurm::words("--comment='two words' \"\""), (Words{"--comment=two words", ""}));
  EXPECT_EQ(slurm::words(" \t\n"), Words{});
  EXPECT_EQ(test::code_of([] { slurm::words("--comment='open"); }), "usage");
}

TEST(SlurmWords, TasksAreNamedByRanges) {
  EXPECT_EQ(slurm::ranges({0}), "0");
  EXPECT_EQ(slurm::ranges({0, 1, 2, 5, 7, 8}), "0-2,5,7-8");
}

}  // namespace
}  // namespace terrazzo::cli
