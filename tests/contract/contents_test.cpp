// Checks that every node's example produces the contents recorded for its version.
#include "tests/contract/contents.h"
#include "tests/support/all_nodes.h"

#include <gtest/gtest.h>

namespace terrazzo {
namespace {
using nlohmann::json;

class RecordedContents : public ::testing::TestWithParam<std::string> {};

TEST_P(RecordedContents, AreGivenAgain) {
  const json all = test::read_contents(), machine = test::this_machine();
  const json* known = test::contents_on(all, machine);
  if (!known) GTEST_SKIP() << "no contents are recorded for " << machine.dump() << "; run ./dev contents";
  if (!known->contains(GetParam()))
    GTEST_SKIP() << "no contents are recorded for this node; run ./dev contents";
  const json now = test::example_contents(test::all_nodes(), *test::all_nodes().find(GetParam()), 2);
  ASSERT_FALSE(now.empty()) << "the example does not use its node";
  EXPECT_EQ(test::compare_contents(GetParam(), known->at(GetParam()), now), "");
}

INSTANTIATE_TEST_SUITE_P(Contract, RecordedContents, ::testing::ValuesIn(test::all_nodes().names()),
                         [](const auto& info) { return info.param; });

json contents(int version, const std::string& key, const std::string& content) {
  return {{"pack", {{"version", version}, {"key", key}, {"outputs", {{"particles", content}}}}}};
}

TEST(CompareContents, SaysWhatToDo) {
  const json recorded = contents(3, "k", "x");
  bool same_version = false;
  EXPECT_EQ(test::compare_contents("Anneal", recorded, contents(3, "k", "x"), &same_version), "");
  EXPECT_FALSE(same_version);

  const auto changed = test::compare_contents("Anneal", recorded, contents(3, "k", "y"), &same_version);
  EXPECT_TRUE(same_version);
  EXPECT_NE(changed.find("same version 3: particles of 'pack' changed. Raise the version"), std::string::npos)
      << changed;

  same_version = false;
  const auto raised = test::compare_contents("Anneal", recorded, contents(4, "l", "y"), &same_version);
  EXPECT_FALSE(same_version);
  EXPECT_NE(raised.find("has version 4, but the recorded contents are of version 3; run ./dev contents"),
            std::string::npos)
      << raised;

  const auto fed = test::compare_contents("Anneal", recorded, contents(3, "l", "y"), &same_version);
  EXPECT_FALSE(same_version);
  EXPECT_NE(fed.find("parameters or inputs of 'pack'"), std::string::npos) << fed;
  EXPECT_NE(test::compare_contents("Anneal", json::object(), recorded).find("not recorded"),
            std::string::npos);
  EXPECT_NE(test::compare_contents("Anneal", recorded, json::object()).find("no longer"), std::string::npos);
}

TEST(CompareContents, AnotherMachineHasNoEntry) {
  json machine = test::this_machine();
  EXPECT_NE(machine.at("libraries").get<std::string>().find("libopenvdb"), std::string::npos)
      << machine.dump();
  const json all = {{{"machine", machine}, {"types", {{"Anneal", 1}}}}};
  ASSERT_NE(test::contents_on(all, machine), nullptr);
  machine["cpu"] = "another";
  EXPECT_EQ(test::contents_on(all, machine), nullptr);
}

}  // namespace
}  // namespace terrazzo
