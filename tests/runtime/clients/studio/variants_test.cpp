// Variants of a result: what they are, what keeping one changes, and what fails alone.
#include <gtest/gtest.h>

#include "tests/runtime/clients/studio/live_graph_fixture.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using test::LiveGraphTest;

class VariantsTest : public LiveGraphTest {
 protected:
  void vary(const std::string& target, const std::string& values, const std::string& node = "sum") {
    live->vary({.target = target, .values = values, .node = node, .port = "out"});
  }
  json tiles() {
    return when([](const json& s) { return !s["variants"]["running"].get<bool>(); })["variants"]["tiles"];
  }
};

TEST_F(VariantsTest, ShowEachValueAndKeepOne) {
  open();
  settled();
  vary("b.value", "1, 2,30");
  const json all = tiles();
  ASSERT_EQ(all.size(), 3u);
  const std::vector<double> sums = {4, 5, 33};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(all[k]["state"], "done");
    EXPECT_EQ(test::number_of(live->value(all[k]["output"]["hash"])), sums[k]);
  }
  live->keep_variant(2);
  const json s = settled();
  EXPECT_EQ(number(s, "sum"), 33);
  EXPECT_EQ(s["nodes"]["sum"]["state"], "cached");
  EXPECT_EQ(s["document"]["varied"], true);
  live->change([](Document& d) { d.undo(); });
  EXPECT_EQ(settled()["document"]["text"], kLiveText);
  EXPECT_EQ(test::code_of([&] { live->keep_variant(3); }), "unknown-variant");
}

TEST_F(VariantsTest, BelongToTheGraphThatTheyWereMadeOf) {
  open();
  vary("b.value", "1,2");
  tiles();
  set("a", "value", "1");
  EXPECT_EQ(settled()["document"]["varied"], false);
  live->change([](Document& d) { d.undo(); });
  EXPECT_EQ(settled()["document"]["varied"], true);
  live->open(Document(file), false);
  EXPECT_EQ(live->state()["variants"], nullptr);
}

TEST_F(VariantsTest, FailAlone) {
  open();
  vary("b.value", "1,x,2");
  json all = tiles();
  EXPECT_EQ(all[0]["state"], "done");
  EXPECT_EQ(all[1]["state"], "failed");
  EXPECT_NE(all[1]["error"].get<std::string>().find("'x'"), std::string::npos) << all[1];
  EXPECT_EQ(all[2]["state"], "done");
  vary("b.value", "1", "write");
  EXPECT_EQ(tiles()[0]["error"], "'write' writes files");
  EXPECT_FALSE(std::filesystem::exists(folder / "sum.txt"));
  vary("gone.value", "1");
  EXPECT_EQ(tiles()[0]["state"], "failed");
  EXPECT_EQ(test::code_of([&] { vary("b.value", "1,,2"); }), "usage");
  EXPECT_EQ(test::code_of([&] { vary("b.value", "1:100:1"); }), "too-large");
  EXPECT_EQ(live->state()["variants"]["target"], "gone.value");
}

}  // namespace
}  // namespace terrazzo
