// What an edit computes, and what it leaves alone.
#include <gtest/gtest.h>

#include "tests/runtime/clients/studio/live_graph_fixture.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::LiveGraphTest;

TEST_F(LiveGraphTest, EvaluatesWhatAnEditAffects) {
  open();
  json s = settled();
  EXPECT_EQ(number(s, "sum"), 5);
  EXPECT_EQ(s["nodes"]["sum"]["state"], "computed");
  set("b", "value", "7");
  s = settled();
  EXPECT_EQ(number(s, "sum"), 10);
  EXPECT_EQ(s["nodes"]["clamp"]["state"], "cached");
  EXPECT_EQ(s["nodes"]["b"]["state"], "computed");
  EXPECT_NE(s["nodes"]["b"]["reasons"][0].get<std::string>().find("2 → 7"), std::string::npos);
  live->change([](Document& d) { d.undo(); });
  s = settled();
  EXPECT_EQ(s["document"]["text"], kLiveText);
  EXPECT_EQ(s["nodes"]["sum"]["state"], "cached");
}

TEST_F(LiveGraphTest, WritesFilesOnlyOnDemand) {
  open();
  settled();
  EXPECT_FALSE(fs::exists(folder / "sum.txt"));
  live->evaluate({});
  const json s = settled();
  EXPECT_EQ(*read_file(folder / "sum.txt"), "5");
  EXPECT_EQ(s["nodes"]["write"]["files"], json::array({"sum.txt"}));
}

TEST_F(LiveGraphTest, WhatIsShownIsComputedFirst) {
  open(kLiveText, false);
  live->show("b");
  live->set_live(true);
  const json s = settled();
  std::vector<std::string> order;
  const auto events = live->events().after(0, std::chrono::milliseconds(0));
  ASSERT_TRUE(events);
  for (const auto& e : *events)
    if (const json j = json::parse(e.data); e.type == "node" && j["state"] == "computed")
      order.push_back(j["path"]);
  ASSERT_FALSE(order.empty());
  EXPECT_EQ(order.front(), "b");
  EXPECT_EQ(order.back(), "sum");
  for (const char* node : {"a", "b", "clamp", "sum"})
    EXPECT_EQ(s["nodes"][node]["state"], "computed") << node;
  EXPECT_EQ(number(s, "sum"), 5);
  live->show("gone");
  set("b", "value", "7");
  EXPECT_EQ(number(settled(), "sum"), 10);
}

TEST_F(LiveGraphTest, OnDemandOnlyPlans) {
  open(kLiveText, false);
  json s = live->state();
  EXPECT_EQ(s["nodes"]["sum"]["state"], "stale");
  EXPECT_FALSE(s["run"]["running"]);
  live->evaluate({"clamp"});
  s = settled();
  EXPECT_EQ(number(s, "clamp"), 3);
  EXPECT_EQ(s["nodes"]["sum"]["state"], "stale");
  EXPECT_EQ(test::code_of([&] { live->evaluate({"nothing"}); }), "unknown-node");
}

TEST_F(LiveGraphTest, OnDemandShowsWhatIsInTheCache) {
  open();
  settled();
  open(kLiveText, false);
  json s = settled();
  EXPECT_EQ(s["nodes"]["sum"]["state"], "cached");
  EXPECT_EQ(number(s, "sum"), 5);
  set("b", "value", "7");
  s = settled();
  EXPECT_EQ(s["nodes"]["sum"]["state"], "stale");
  EXPECT_EQ(number(s, "clamp"), 3);
}

TEST_F(LiveGraphTest, FailuresAndTheirConsequencesAreShown) {
  open(
      "terrazzo: 1\nnodes:\n  f: {type: Fail}\n  c: {type: Clamp, inputs: {in: f.out}}\n  d: {type: "
      "Constant}\n");
  const json s = settled();
  EXPECT_EQ(s["nodes"]["f"]["state"], "failed");
  EXPECT_EQ(s["nodes"]["f"]["error"]["code"], "no-luck");
  EXPECT_EQ(s["nodes"]["c"]["state"], "skipped");
  EXPECT_EQ(s["nodes"]["d"]["state"], "computed");
}

TEST_F(LiveGraphTest, OneNodeIsCanceled) {
  open("terrazzo: 1\nnodes:\n  e: {type: Endless}\n  d: {type: Constant}\n");
  when([](const json& s) { return s["nodes"]["e"]["state"] == "running"; });
  live->cancel("e");
  const json s = settled();
  EXPECT_EQ(s["nodes"]["e"]["state"], "canceled");
  EXPECT_EQ(s["nodes"]["d"]["state"], "computed");
}

// An edit elsewhere neither stops a computation nor hides that it goes on.
TEST_F(LiveGraphTest, WhatAnEditDoesNotAffectGoesOn) {
  open("terrazzo: 1\nnodes:\n  e: {type: Endless}\n  d: {type: Constant, params: {value: 1}}\n");
  when([](const json& s) { return s["nodes"]["e"]["state"] == "running"; });
  set("d", "value", "2");
  const json s = when([](const json& s) { return s["nodes"]["d"]["state"] == "computed"; });
  EXPECT_EQ(number(s, "d"), 2);
  EXPECT_TRUE(s["run"]["running"]);
  live->evaluate({"d"});
  EXPECT_TRUE(when([](const json& s) { return s["nodes"]["d"]["state"] == "cached"; })["run"]["running"]);
  live->cancel("");
  EXPECT_EQ(settled()["nodes"]["e"]["state"], "canceled");
}

TEST_F(LiveGraphTest, PricesAreThoseOfTheNodesThatAnEditRuns) {
  open();
  settled();
  const Edit edit{Edit::Kind::SetParameter, "b", "value", {false, {"7"}, {}}};
  const json price = live->price({edit});
  std::vector<std::string> paths;
  for (const auto& n : price["nodes"]) paths.push_back(n["path"]);
  EXPECT_EQ(paths, (std::vector<std::string>{"b", "sum"}));  // not the node that writes a file
  EXPECT_NE(price["nodes"][0]["reason"].get<std::string>().find("2 → 7"), std::string::npos);
  double sum = 0;
  for (const auto& n : price["nodes"]) {
    EXPECT_GT(n["seconds"], 0) << n["path"];
    sum += n["seconds"].get<double>();
  }
  EXPECT_DOUBLE_EQ(price["seconds"], sum);
  EXPECT_EQ(live->state()["document"]["text"], kLiveText);
  EXPECT_EQ(live->price({})["nodes"], json::array());
  const Edit bad{Edit::Kind::SetParameter, "b", "value", {false, {"much"}, {}}};
  EXPECT_EQ(test::code_of([&] { live->price({bad}); }), "bad-value");
}

TEST_F(LiveGraphTest, ShowsPreviewsUntilTheResult) {
  open("terrazzo: 1\nnodes:\n  a: {type: Sketch, params: {value: 8, wait: 1}}\n");
  const auto preview = [](const json& s) -> const json& { return s["nodes"]["a"]["previews"]; };
  json s = when([&](const json& now) { return preview(now).contains("out"); });
  EXPECT_EQ(preview(s)["out"]["type"], "Table");
  const std::uint64_t first = preview(s)["out"]["number"];
  EXPECT_EQ(test::number_of(live->preview(first)), 4);
  // The next computation's preview takes its place; none of the canceled one arrives later.
  set("a", "value", "10");
  s = when([&](const json& now) {
    return preview(now).contains("out") && preview(now)["out"]["number"] != first;
  });
  EXPECT_EQ(test::number_of(live->preview(preview(s)["out"]["number"])), 5);
  EXPECT_FALSE(live->preview(first));
  set("a", "wait", "0");
  s = settled();
  EXPECT_EQ(number(s, "a"), 10);
  EXPECT_TRUE(preview(s).empty());
  // A canceled node shows its earlier result.
  set("a", "wait", "2");
  when([&](const json& now) { return preview(now).contains("out"); });
  live->cancel("a");
  s = settled();
  EXPECT_EQ(s["nodes"]["a"]["state"], "canceled");
  EXPECT_TRUE(preview(s).empty());
  EXPECT_EQ(number(s, "a"), 10);
}

}  // namespace
}  // namespace terrazzo
