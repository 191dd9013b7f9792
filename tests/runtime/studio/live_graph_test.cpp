// A document that is evaluated while it is edited.
#include "runtime/studio/live_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "nodes/data/table.h"
#include "runtime/files.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using studio::Document;
using studio::LiveGraph;

const std::string kLiveText =
    "terrazzo: 1\n"
    "nodes:\n"
    "  a: {type: Constant, params: {value: 5}}\n"
    "  b: {type: Constant, params: {value: 2}}\n"
    "  clamp: {type: Clamp, inputs: {in: a.out}, params: {low: 0, high: 3}}\n"
    "  sum: {type: Add, inputs: {a: clamp.out, b: b.out}}\n"
    "  write: {type: Write, inputs: {in: sum.out}, params: {path: sum.txt}}\n";

class LiveGraphTest : public ::testing::Test {
 protected:
  void open(const std::string& text = kLiveText, bool automatic = true) {
    write_text_atomically(file, text);
    live =
        std::make_unique<LiveGraph>(test::arithmetic(), test::value_types(),
                                    SessionOptions{.cache_folder = folder / "cache", .output_folder = folder},
                                    Document(file), Overrides{}, automatic);
  }
  void set(const std::string& node, const std::string& name, const std::string& value) {
    live->change([&](Document& d) {
      d.edit({{Edit::Kind::SetParameter, node, name, {false, {value}, {}}}});
    });
  }
  // The state once `ready` holds. Fails after 20 s.
  json when(const std::function<bool(const json&)>& ready) {
    for (int k = 0; k < 2000; ++k) {
      const json s = live->state();
      if (ready(s)) return s;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << live->state().dump(1);
    return live->state();
  }
  json settled() {
    return when([](const json& s) {
      for (const auto& [path, n] : s["nodes"].items())
        if (n["state"] == "waiting" || n["state"] == "running") return false;
      return !s["run"]["running"].get<bool>();
    });
  }
  double number(const json& state, const std::string& node) {
    return test::number_of(live->value(state["nodes"][node]["outputs"]["out"]["hash"]));
  }

  const fs::path folder = test::temporary_folder(), file = folder / "live.yaml";
  std::unique_ptr<LiveGraph> live;
};

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

TEST_F(LiveGraphTest, AGraphWithErrorsOpens) {
  open("terrazzo: 1\nnodes:\n  a: {type: Constnat}\n  b: {type: Constant}\n");
  json s = live->state();
  EXPECT_FALSE(s["document"]["valid"]);
  EXPECT_EQ(s["document"]["nodes"].size(), 2u);
  EXPECT_EQ(s["document"]["messages"][0]["line"], 3);
  EXPECT_EQ(s["document"]["messages"][0]["node"], "a");
  EXPECT_EQ(test::code_of([&] { live->evaluate({}); }), "invalid-graph");
  live->change([](Document& d) { d.replace("terrazzo: 1\nnodes: [\n"); });  // no YAML at all
  EXPECT_EQ(live->state()["document"]["messages"][0]["code"], "yaml");
  live->change([](Document& d) { d.replace(kLiveText); });
  EXPECT_EQ(number(settled(), "sum"), 5);
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

TEST_F(LiveGraphTest, ARepeatedNodeIsOneNodeOfTheDocument) {
  open(
      "terrazzo: 1\nnodes:\n"
      "  c: {type: Constant, each: {k: [1, 2, 3]}, params: {value: '${k}'}}\n"
      "  sum: {type: Sum, inputs: {in: c.out}}\n"
      "  e: {type: Endless, each: {k: [1, 2]}}\n");
  when([](const json& s) {
    return s["nodes"]["e[1]"]["state"] == "running" || s["nodes"]["e[2]"]["state"] == "running";
  });
  live->cancel("e");  // all elements
  json s = settled();
  EXPECT_EQ(s["nodes"]["e[1]"]["state"], "canceled");
  EXPECT_EQ(s["nodes"]["e[2]"]["state"], "canceled");
  EXPECT_EQ(number(s, "sum"), 6);
  ASSERT_EQ(s["document"]["nodes"].size(), 3u);
  EXPECT_EQ(s["document"]["nodes"][0]["each"]["k"]["value"], json::array({"1", "2", "3"}));
  EXPECT_EQ(s["nodes"].size(), 6u);
  live->change([](Document& d) {
    d.replace(
        "terrazzo: 1\nnodes:\n  c: {type: Constant, each: {k: [1, 2, 4]}, params: {value: '${k}'}}\n"
        "  sum: {type: Sum, inputs: {in: c.out}}\n");
  });
  s = settled();
  EXPECT_EQ(number(s, "sum"), 7);
  EXPECT_EQ(s["nodes"]["c[2]"]["state"], "cached");
  EXPECT_EQ(s["nodes"]["c[4]"]["state"], "computed");
  live->change([](Document& d) { d.edit({{Edit::Kind::Connect, "sum", "in", {}, {"c[4].out"}}}); });
  EXPECT_EQ(number(settled(), "sum"), 4);
}

// An edit elsewhere neither stops a computation nor hides that it goes on.
TEST_F(LiveGraphTest, ABypassedNodeDoesNotRunAndShowsWhatPasses) {
  open();
  settled();
  const auto bypass = [&](const std::string& node, bool on) {
    live->change([&](Document& d) { d.edit({{.kind = Edit::Kind::SetBypass, .node = node, .bypass = on}}); });
  };
  bypass("clamp", true);
  json s = settled();
  EXPECT_EQ(number(s, "sum"), 7);
  EXPECT_FALSE(s["nodes"].contains("clamp"));
  const json& node = s["document"]["nodes"][2];
  EXPECT_EQ(node["bypass"], true);
  EXPECT_EQ(node["inner"], (json{{"out", {{"path", "a"}, {"port", "out"}}}}));
  EXPECT_NO_THROW(live->evaluate({"clamp"}));
  settled();
  // What the file says, `terrazzo run` does too.
  const fs::path copy = folder / "copy.yaml";  // not the file itself, which would be read again
  write_text_atomically(copy, s["document"]["text"].get<std::string>());
  Session fresh(test::arithmetic(), test::value_types(), {});
  EXPECT_FALSE(has_errors(fresh.open(copy)));
  EXPECT_EQ(test::number_of(fresh.value("sum.out")), 7);
  bypass("b", true);  // nothing can take its place
  s = settled();
  EXPECT_EQ(s["document"]["messages"][0]["code"], "cannot-bypass");
  EXPECT_EQ(s["document"]["messages"][0]["node"], "sum");
  live->change([](Document& d) { d.undo(); });
  live->change([](Document& d) { d.undo(); });
  s = settled();
  EXPECT_EQ(s["document"]["text"], kLiveText);
  EXPECT_EQ(number(s, "sum"), 5);
}

TEST_F(LiveGraphTest, WhatAnEditDoesNotAffectGoesOn) {
  open("terrazzo: 1\nnodes:\n  e: {type: Endless}\n  d: {type: Constant, params: {value: 1}}\n");
  when([](const json& s) { return s["nodes"]["e"]["state"] == "running"; });
  set("d", "value", "2");
  const json s = when([](const json& s) { return s["nodes"]["d"]["state"] == "computed"; });
  EXPECT_EQ(number(s, "d"), 2);
  EXPECT_TRUE(s["run"]["running"]);
  live->cancel("");
  EXPECT_EQ(settled()["nodes"]["e"]["state"], "canceled");
}

TEST_F(LiveGraphTest, AFileThatChangesIsReadAgain) {
  open();
  settled();
  std::string other = kLiveText;
  other.replace(other.find("value: 2"), 8, "value: 4");
  write_text_atomically(file, other);
  when([](const json& s) { return s["document"]["text"] != kLiveText; });
  EXPECT_EQ(number(settled(), "sum"), 7);
  set("b", "value", "9");
  write_text_atomically(file, kLiveText);  // now there are unsaved changes
  const json s = when([](const json& s) { return s["document"]["disk_changed"].get<bool>(); });
  EXPECT_NE(s["document"]["text"], kLiveText);
}

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

TEST_F(LiveGraphTest, EarlierStatesAreKeptAndComeBack) {
  open();
  const double first = number(settled(), "sum");
  when([&](const json&) { return live->history().size() == 1; });  // ends are noticed after up to 50 ms
  set("b", "value", "7");
  when([&](const json&) { return live->history().size() == 2; });
  const json list = live->history();
  EXPECT_EQ(list[0]["changed"], "");
  EXPECT_EQ(list[1]["changed"], "b: value: 7");
  const json past = live->past(list[0]["number"]);
  EXPECT_EQ(past["text"], kLiveText);
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

TEST_F(LiveGraphTest, SubgraphsShowTheirDocument) {
  write_text_atomically(
      folder / "part.yaml",
      "terrazzo: 1\nnodes:\n  inner: {type: Constant, params: {value: 4}}\noutputs: {out: inner.out}\n");
  open("terrazzo: 1\nnodes:\n  part: {graph: part.yaml}\n  sum: {type: Sum, inputs: {in: part.out}}\n");
  settled();
  const json inside = live->subgraph("part");
  EXPECT_EQ(inside["nodes"][0]["name"], "inner");
  EXPECT_EQ(inside["file"], (folder / "part.yaml").string());
  EXPECT_EQ(test::code_of([&] { live->subgraph("sum"); }), "unknown-node");
  EXPECT_EQ(test::code_of([&] { live->subgraph("part/inner"); }), "unknown-node");
  EXPECT_EQ(test::code_of([&] { live->subgraph(""); }), "unknown-node");
}

TEST_F(LiveGraphTest, AGraphThatAnotherProgramChangesIsReadAgain) {
  open();
  settled();
  std::string other = kLiveText;
  other.replace(other.find("value: 2"), 8, "value: 4");
  write_text_atomically(file, other);
  EXPECT_EQ(number(when([&](const json& s) { return s["document"]["text"] == other; }), "a"), 5);
  EXPECT_EQ(number(settled(), "sum"), 7);
  // With unsaved changes, both are kept until somebody decides.
  set("b", "value", "7");
  write_text_atomically(file, kLiveText);
  const json s = when([](const json& s) { return s["document"]["disk_changed"] == true; });
  EXPECT_NE(s["document"]["text"].get<std::string>().find("value: 7"), std::string::npos);
  EXPECT_EQ(test::code_of([&] { live->change([](Document& d) { d.save(false); }); }), "file-changed");
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

TEST_F(LiveGraphTest, SavingAndMovingNodesStartNoEvaluation) {
  open();
  settled();
  set("b", "value", "7");
  settled();
  const auto started = [&](std::uint64_t after) {
    const auto events = live->events().after(after, std::chrono::milliseconds(0));
    return std::ranges::any_of(*events, [](const auto& e) { return e.type == "node"; });
  };
  auto number = live->events().last();
  live->change([](Document& d) { d.save(false); });
  EXPECT_TRUE(live->state()["document"]["saved"]);
  const json places = {{"places", {{"a", {1, 2}}}}};
  live->arrange(places);
  EXPECT_EQ(live->state()["document"]["arrangement"], places);
  live->change([](Document& d) { d.undo(); });
  EXPECT_EQ(live->state()["document"]["arrangement"], json::object());
  EXPECT_FALSE(started(number));
  number = live->events().last();
  live->change([](Document& d) { d.undo(); });
  EXPECT_TRUE(started(number));
  // Another program moves a node.
  write_text_atomically(folder / "live.studio.json", places.dump());
  when([&](const json& s) { return s["document"]["arrangement"] == places; });
}

TEST_F(LiveGraphTest, TenMegabytesOfTextOpenAndAreEdited) {
  const std::string comments = "# " + std::string(10 << 20, 'x') + "\n";
  open(comments + kLiveText);
  EXPECT_EQ(number(settled(), "sum"), 5);
  set("b", "value", "7");
  const json s = settled();
  EXPECT_EQ(number(s, "sum"), 10);
  EXPECT_EQ(s["document"]["text"].get<std::string>().size(), comments.size() + kLiveText.size());
}

}  // namespace
}  // namespace terrazzo
