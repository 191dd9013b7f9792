#include "nodes/photograph/segment/proposal.h"

#include <gtest/gtest.h>

namespace terrazzo {
namespace {
using namespace segment;

Proposal proposal(std::vector<std::int32_t> ids, std::vector<double> confidence) {
  Proposal a;
  a.labels.ids = std::move(ids);
  a.labels.classes.assign(confidence.size(), 0);
  a.confidence = std::move(confidence);
  return a;
}

TEST(Proposal, TellsWhatAnotherLeavesOut) {
  // Four pixels of a sure particle, two of a doubtful one, two of binder.
  const Proposal a = proposal({1, 1, 1, 1, 2, 2, 0, 0}, {0.9, 0.3});
  EXPECT_EQ(a.left_out_by(a), 0);
  EXPECT_NEAR(a.left_out_by(proposal({7, 0, 0, 0, 7, 7, 7, 7}, std::vector<double>(7, 1.0))), 2.7 / 4.2,
              1e-12);
  EXPECT_NEAR(a.left_out_by(proposal({7, 7, 7, 7, 0, 0, 0, 0}, std::vector<double>(7, 1.0))), 0.6 / 4.2,
              1e-12);
  EXPECT_EQ(a.left_out_by(proposal({0, 0, 0, 0, 0, 0, 0, 0}, {})), 1);
  EXPECT_EQ(proposal({0, 0, 0, 0, 0, 0, 0, 0}, {}).left_out_by(a), 0);
}

}  // namespace
}  // namespace terrazzo
