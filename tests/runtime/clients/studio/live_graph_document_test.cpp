// The document of a graph that is evaluated: errors, subgraphs, repeated and bypassed nodes, files that
// change.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/runtime/clients/studio/live_graph_fixture.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::LiveGraphTest;

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

TEST_F(LiveGraphTest, SubgraphsAreEditedInTheirFiles) {
  const fs::path part = folder / "part.yaml";
  const std::string text =
      "terrazzo: 1\nnodes:\n  inner: {type: Constant, params: {value: 4}}  # kept\noutputs: {out: "
      "inner.out}\n";
  write_text_atomically(part, text);
  open("terrazzo: 1\nnodes:\n  part: {graph: part.yaml}\n  sum: {type: Sum, inputs: {in: part.out}}\n");
  settled();
  const auto set_inner = [&](const std::string& value) {
    live->change(
        [&](Document& d) {
          d.edit({{Edit::Kind::SetParameter, "inner", "value", {false, {value}, {}}}});
        },
        "part");
  };
  set_inner("6");
  EXPECT_EQ(number(settled(), "sum"), 6);
  std::string edited = text;
  edited.replace(edited.find("value: 4"), 8, "value: 6");
  EXPECT_EQ(*read_file(part), edited);
  EXPECT_EQ(live->state()["document"]["can_undo"], false);
  EXPECT_EQ(live->subgraph("part")["can_undo"], true);
  live->arrange({{"places", {{"inner", {3, 4}}}}}, "", "part");
  EXPECT_EQ(live->subgraph("part")["arrangement"]["places"]["inner"], json({3, 4}));
  for (int k = 0; k < 2; ++k) live->change([](Document& d) { d.undo(); }, "part");
  EXPECT_EQ(number(settled(), "sum"), 4);
  EXPECT_EQ(*read_file(part), text);

  // What another program wrote meanwhile stays.
  write_text_atomically(part, edited + "# mine\n");
  set_inner("7");
  EXPECT_NE(read_file(part)->find("# mine"), std::string::npos);
  EXPECT_EQ(number(settled(), "sum"), 7);

  // Files elsewhere are not changed.
  const fs::path elsewhere = test::temporary_folder();
  write_text_atomically(elsewhere / "part.yaml", text);
  fs::create_directory_symlink(elsewhere, folder / "link");
  for (const fs::path& outside : {elsewhere / "part.yaml", fs::path("link/part.yaml")}) {
    live->open(Document((write_text_atomically(
                             file, "terrazzo: 1\nnodes:\n  part: {graph: " + outside.string() + "}\n"),
                         file)),
               true);
    settled();
    EXPECT_EQ(live->subgraph("part")["read_only"], true);
    EXPECT_EQ(test::code_of([&] { set_inner("5"); }), "read-only");
  }
  EXPECT_EQ(*read_file(elsewhere / "part.yaml"), text);
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
