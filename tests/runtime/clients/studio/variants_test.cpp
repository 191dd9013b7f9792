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

// The file of a subgraph has the value; all nodes that use it follow.
TEST_F(VariantsTest, VaryWhatIsInASubgraph) {
  const auto part = folder / "part.yaml";
  const std::string text =
      "terrazzo: 1\nnodes:\n  c: {type: Constant, params: {value: 1}}\noutputs: {out: c.out}\n";
  write_text_atomically(part, text);
  open(
      "terrazzo: 1\nnodes:\n  p: {graph: part.yaml}\n  q: {graph: part.yaml}\n"
      "  sum: {type: Add, inputs: {a: p.out, b: q.out}}\n");
  EXPECT_EQ(number(settled(), "sum"), 2);

  const Edit seven{Edit::Kind::SetParameter, "c", "value", {false, {"7"}, {}}};
  const json price = live->price({seven}, "p");
  EXPECT_EQ(price["nodes"].size(), 3u) << price;
  EXPECT_EQ(*read_file(part), text);
  EXPECT_EQ(test::code_of([&] { live->price({seven}, "gone"); }), "unknown-node");

  live->vary({.target = "c.value", .values = "1,5", .node = "sum", .port = "out", .scope = "p"});
  const json all = tiles();
  EXPECT_EQ(test::number_of(live->value(all[0]["output"]["hash"])), 2);
  EXPECT_EQ(test::number_of(live->value(all[1]["output"]["hash"])), 10);
  EXPECT_EQ(*read_file(part), text);
  live->keep_variant(1);
  json s = settled();
  EXPECT_EQ(number(s, "sum"), 10);
  EXPECT_EQ(s["document"]["varied"], true);
  EXPECT_EQ(s["document"]["can_undo"], false);
  EXPECT_NE(read_file(part)->find("value: 5"), std::string::npos);

  // History has both states of the file.
  when([&](const json&) { return live->history().size() == 2; });
  EXPECT_NE(live->history()[1]["changed"].get<std::string>().find("value: 5"), std::string::npos);
  live->restore(live->history()[0]["number"]);
  s = settled();
  EXPECT_EQ(number(s, "sum"), 2);
  EXPECT_EQ(*read_file(part), text);
  live->change([](Document& d) { d.undo(); }, "p");
  EXPECT_EQ(number(settled(), "sum"), 10);
}

}  // namespace
}  // namespace terrazzo
