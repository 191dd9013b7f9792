// Tests the comparison of recorded contents. EveryNode.GivesTheRecordedContents applies it to every node.
#include "tests/contract/contents.h"

#include <gtest/gtest.h>

namespace terrazzo {
namespace {
using nlohmann::json;

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
