// Events that pages receive, and the states that they can return to.
#include <gtest/gtest.h>

#include <set>

#include "tests/runtime/clients/studio/live_graph_fixture.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using test::LiveGraphTest;

// A run that finds everything in the cache ends before anyone looks.
TEST_F(LiveGraphTest, TheEndOfEveryRunIsReported) {
  open();
  std::uint64_t seen = settled()["number"];
  for (int k = 0; k < 6; ++k) {
    set("b", "value", k % 2 ? "2" : "3");
    json last;
    for (int tries = 0; tries < 100 && (last.is_null() || last["running"].get<bool>()); ++tries) {
      const auto events = live->events().after(seen, std::chrono::milliseconds(200));
      ASSERT_TRUE(events);
      for (const auto& e : *events) {
        if (e.type == "run") last = json::parse(e.data);
        seen = e.number;
      }
    }
    EXPECT_EQ(last["running"], false) << k;
  }
}

TEST_F(LiveGraphTest, EventsResume) {
  open();
  const json s = settled();
  const std::uint64_t number = s["number"];
  set("b", "value", "3");
  const auto events = live->events().after(number, std::chrono::milliseconds(0));
  ASSERT_TRUE(events && !events->empty());
  EXPECT_EQ(events->front().number, number + 1);
  // The end of the first run may not have been reported before.
  const std::size_t at = events->front().type == "run" ? 1 : 0;
  ASSERT_GT(events->size(), at);
  EXPECT_EQ((*events)[at].type, "document");
  EXPECT_FALSE(live->events().after(number + 100000, std::chrono::milliseconds(0)));  // of another session
  EXPECT_EQ(test::code_of([&] { live->value("0123"); }), "unknown-value");
}

TEST_F(LiveGraphTest, OnlyNodesThatChangeAreReported) {
  open();
  settled();
  const auto number = live->events().last();
  set("b", "value", "7");
  settled();
  std::set<std::string> told;
  const auto events = live->events().after(number, std::chrono::milliseconds(0));
  for (const auto& e : *events)
    if (e.type == "node") told.insert(json::parse(e.data)["path"]);
  EXPECT_EQ(told.count("sum"), 1u);
  EXPECT_EQ(told.count("write"), 0u);  // it waits for somebody who wants files, as before
}

// More nodes than a page can draw: it gets the text, and what failed.
TEST_F(LiveGraphTest, OfALargeGraphOnlyFailuresAndTheTextAreReported) {
  std::string text = "terrazzo: 1\nnodes:\n";
  for (int k = 0; k < 2100; ++k)
    text += "  c" + std::to_string(k) + ": {type: Constant, params: {value: 1}}\n";
  open(text + "  bad: {type: Fail, inputs: {in: c7.out}}\n");
  json s = settled();
  EXPECT_EQ(s["document"]["nodes"], json::array());
  EXPECT_EQ(s["document"]["node_count"], 2101);
  ASSERT_EQ(s["nodes"].size(), 1u);
  EXPECT_EQ(s["nodes"]["bad"]["state"], "failed");
  const auto number = live->events().last();
  set("c7", "value", "2");
  settled();
  const auto events = live->events().after(number, std::chrono::milliseconds(0));
  ASSERT_TRUE(events);
  for (const auto& e : *events)
    EXPECT_TRUE(e.type != "node" || json::parse(e.data)["path"] == "bad") << e.data;
  // As many errors as nodes: some of them, and how many there are beyond.
  std::string broken = text;
  for (std::size_t at = 0; (at = broken.find("value: 1", at)) != std::string::npos; at += 8)
    broken.replace(at, 8, "value: x");
  live->change([&](Document& d) { d.replace(broken); });
  s = live->state();
  EXPECT_EQ(s["document"]["messages"].size(), 1001u);
  EXPECT_EQ(s["document"]["messages"].back()["message"], "1100 more messages");
}

TEST_F(LiveGraphTest, EarlierStatesAreKeptAndComeBack) {
  open();
  const double first = number(settled(), "sum");
  when([&](const json&) { return live->history().size() == 1; });  // ends are noticed after up to 50 ms
  set("b", "value", "7");
  when([&](const json&) { return live->history().size() == 2; });
  const json list = live->history();
  EXPECT_EQ(list[0]["changed"], "");
  EXPECT_EQ(list[1]["changed"], "b: value: 7");
  EXPECT_FALSE(list[0].contains("output"));
  const json seen = live->history("sum", "out");
  EXPECT_EQ(test::number_of(live->value(seen[0]["output"]["hash"])), first);
  EXPECT_NE(seen[0]["output"], seen[1]["output"]);
  const json past = live->past(list[0]["number"]);
  EXPECT_EQ(test::number_of(live->value(past["nodes"]["sum"]["outputs"]["out"]["hash"])), first);
  live->restore(list[0]["number"]);
  const json s = settled();
  EXPECT_EQ(s["document"]["text"], kLiveText);
  EXPECT_EQ(s["document"]["can_undo"], true);
  EXPECT_EQ(test::code_of([&] { live->past(99); }), "unknown-state");
  live->open(Document(file), true);
  EXPECT_EQ(live->history().size() <= 1, true);  // states of another document are gone
}

TEST_F(LiveGraphTest, AnEditRightAfterTheEndKeepsTheStateBefore) {
  open();
  settled();
  for (int k = 3; k < 9; ++k) {
    set("b", "value", std::to_string(k));
    settled();  // at the next edit, the end may not be reported yet
  }
  set("b", "value", "9");
  EXPECT_GE(live->history().size(), 7u);
}

}  // namespace
}  // namespace terrazzo
