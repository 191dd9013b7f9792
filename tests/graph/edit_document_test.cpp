// Edits of graph files change their own lines and nothing else.
#include "graph/document/edit_document.h"

#include <gtest/gtest.h>

#include "tests/support/code_of.h"
#include "tests/support/replaced.h"

namespace terrazzo {
namespace {
using test::replaced;
using Kind = Edit::Kind;

const std::string kGraph =
    "# A comment\n"
    "terrazzo: 1\n"
    "parameters: {size: {type: numbers, default: 40}}\n"
    "nodes:\n"
    "  photo: {type: LoadImage, params: {path: a.png}}  # the photograph\n"
    "\n"
    "  segment:  # finds stones\n"
    "    type: Segment\n"
    "    inputs:\n"
    "      image: photo.image\n"
    "    params:\n"
    "      # at least this\n"
    "      min_area: 20  # pixels\n"
    "      classes: [a,\n"
    "        b]\n"
    "  # Sizes\n"
    "  pack:\n"
    "    type: Pack\n"
    "    inputs: {profiles: segment.profiles, extra: [segment.labels, photo.image]}\n"
    "outputs: {profiles: segment.profiles}\n"
    "# The end\n";

std::string after(const Edit& e, const std::string& text = kGraph) {
  return edit_document(text, "g.yaml", e);
}

Edit set(const std::string& node, const std::string& name, const std::string& value) {
  return {Kind::SetParameter, node, name, {false, {value}, {}}};
}

TEST(EditDocument, ParametersChangeInPlace) {
  EXPECT_EQ(after(set("segment", "min_area", "30")), replaced(kGraph, "min_area: 20", "min_area: 30"));
  EXPECT_EQ(after(set("photo", "path", "b c.png")), replaced(kGraph, "a.png", "b c.png"));
  EXPECT_EQ(after({Kind::SetParameter, "segment", "classes", {true, {"x"}, {}}}),
            replaced(kGraph, "[a,\n        b]", "[x]"));
  EXPECT_EQ(after({Kind::SetDefault, "", "size", {true, {"1", "2", "3"}, {}}}),
            replaced(kGraph, "default: 40", "default: [1, 2, 3]"));
}

TEST(EditDocument, ParametersAreAdded) {
  EXPECT_EQ(after(set("photo", "scale", "2")), replaced(kGraph, "a.png}", "a.png, scale: 2}"));
  EXPECT_EQ(after(set("segment", "seed", "${seed}")),
            replaced(kGraph, "        b]\n", "        b]\n      seed: \"${seed}\"\n"));
  EXPECT_EQ(after(set("pack", "seed", "3")),
            replaced(kGraph, "photo.image]}\n", "photo.image]}\n    params: {seed: 3}\n"));
  EXPECT_EQ(after(set("a", "b", "c"), "terrazzo: 1\nnodes: {a: {type: X}}"),
            "terrazzo: 1\nnodes: {a: {type: X, params: {b: c}}}");
  EXPECT_EQ(after(set("a", "b", "c"), "terrazzo: 1\nnodes:\n  a:\n    type: X\n    params:"),
            "terrazzo: 1\nnodes:\n  a:\n    type: X\n    params: {b: c}");
}

TEST(EditDocument, ParametersAreReset) {
  EXPECT_EQ(after({Kind::ResetParameter, "segment", "min_area"}),
            replaced(kGraph, "      min_area: 20  # pixels\n", ""));
  EXPECT_EQ(after({Kind::ResetParameter, "photo", "path"}), replaced(kGraph, ", params: {path: a.png}", ""));
  EXPECT_EQ(after({Kind::ResetParameter, "photo", "nothing"}), kGraph);
}

TEST(EditDocument, WiresAreConnectedAndRemoved) {
  EXPECT_EQ(after({Kind::Connect, "segment", "image", {}, {"photo.other"}}),
            replaced(kGraph, "image: photo.image\n", "image: photo.other\n"));
  EXPECT_EQ(after({Kind::Connect, "segment", "image"}),
            replaced(kGraph, "    inputs:\n      image: photo.image\n", ""));
  EXPECT_EQ(after({Kind::Connect, "pack", "extra", {}, {"segment.labels"}}),
            replaced(kGraph, "[segment.labels, photo.image]", "segment.labels"));
  EXPECT_EQ(after({Kind::Connect, "photo", "in", {}, {"pack.a", "pack.b"}}),
            replaced(kGraph, "a.png}}", "a.png}, inputs: {in: [pack.a, pack.b]}}"));
}

TEST(EditDocument, NodesAreAddedRemovedAndRenamed) {
  EXPECT_EQ(after({.kind = Kind::AddNode, .node = "sheet", .type = "ContactSheet"}),
            replaced(kGraph, "outputs:", "  sheet:\n    type: ContactSheet\noutputs:"));
  EXPECT_EQ(after({.kind = Kind::RemoveNode, .node = "segment"}),
            "# A comment\n"
            "terrazzo: 1\n"
            "parameters: {size: {type: numbers, default: 40}}\n"
            "nodes:\n"
            "  photo: {type: LoadImage, params: {path: a.png}}  # the photograph\n"
            "\n"
            "  # Sizes\n"
            "  pack:\n"
            "    type: Pack\n"
            "    inputs: {extra: photo.image}\n"
            "# The end\n");
  EXPECT_EQ(after({.kind = Kind::RemoveNode, .node = "a"}, "terrazzo: 1\nnodes:\n  a: {type: X}\n"),
            "terrazzo: 1\nnodes: {}\n");
  EXPECT_EQ(after({.kind = Kind::RenameNode, .node = "photo", .to = "picture"}),
            replaced(replaced(replaced(kGraph, "  photo:", "  picture:"), "image: photo.image",
                              "image: picture.image"),
                     ", photo.image]", ", picture.image]"));
}

TEST(EditDocument, ItemsAreAppendedAndRemoved) {
  const auto append = [](const std::string& node, const std::string& name, const std::string& item) {
    return Edit{Kind::AppendItem, node, name, {false, {item}, {}}};
  };
  const std::string flow = replaced(kGraph, "        b]", "        b, split 1 2 3 4]");
  EXPECT_EQ(after(append("segment", "classes", "split 1 2 3 4")), flow);
  EXPECT_EQ(after({.kind = Kind::RemoveItem, .node = "segment", .name = "classes", .index = 0}, flow),
            replaced(flow, "[a,\n        b, split", "[b, split"));
  EXPECT_EQ(after({.kind = Kind::RemoveItem, .node = "segment", .name = "classes", .index = 2}, flow),
            kGraph);
  const std::string one =
      replaced(kGraph, "photo.image]}\n", "photo.image]}\n    params:\n      edits:\n        - delete 1 2\n");
  EXPECT_EQ(after(append("pack", "edits", "delete 1 2")), one);
  const std::string noted = replaced(one, "delete 1 2\n", "delete 1 2  # a speck\n        # more\n");
  const std::string two = replaced(noted, "a speck\n", "a speck\n        - \"1: merge 1 2, 3 4\"\n");
  EXPECT_EQ(after(append("pack", "edits", "1: merge 1 2, 3 4"), noted), two);
  EXPECT_EQ(after({.kind = Kind::RemoveItem, .node = "pack", .name = "edits", .index = 1}, two), noted);
  EXPECT_EQ(after({.kind = Kind::RemoveItem, .node = "pack", .name = "edits", .index = 0}, noted),
            replaced(noted, "    params:\n      edits:\n        - delete 1 2  # a speck\n", ""));
  EXPECT_EQ(after(append("photo", "path", "b.png")), replaced(kGraph, "path: a.png", "path: [b.png]"));
  EXPECT_EQ(test::code_of(
                [] { after({.kind = Kind::RemoveItem, .node = "segment", .name = "classes", .index = 2}); }),
            "unknown-item");
}

TEST(EditDocument, ConsumersAreRewired) {
  EXPECT_EQ(
      after({.kind = Kind::Rewire, .node = "x", .name = "segment.profiles", .to = "measure.profiles"}),
      replaced(replaced(kGraph, "{profiles: segment.profiles, extra", "{profiles: measure.profiles, extra"),
               "outputs: {profiles: segment.profiles}", "outputs: {profiles: measure.profiles}"));
  EXPECT_EQ(after({.kind = Kind::Rewire, .node = "segment", .name = "photo.image", .to = "a.b"}),
            replaced(kGraph, "segment.labels, photo.image", "segment.labels, a.b"));
  EXPECT_EQ(after({.kind = Kind::SetSubgraph, .node = "a", .graph = "../b.yaml"},
                  "terrazzo: 1\nnodes: {a: {graph: b.yaml}}"),
            "terrazzo: 1\nnodes: {a: {graph: ../b.yaml}}");
}

TEST(EditDocument, OddTextIsKeptOrRefused) {
  const std::string shared =
      "terrazzo: 1\nnodes:\n  a: {type: X, params: {p: &v 1}}\n  b: {type: X, params: {p: *v}}\n";
  EXPECT_EQ(after(set("b", "p", "2"), shared), replaced(shared, "*v", "2"));
  // The anchor's value is also b's, so the edit would change both.
  EXPECT_EQ(test::code_of([&] { after(set("a", "p", "2"), shared); }), "cannot-edit");
  const std::string merged = "terrazzo: 1\nnodes:\n  a: &a {type: X, params: {p: 1}}\n  b: *a\n";
  EXPECT_EQ(test::code_of([&] { after(set("b", "p", "2"), merged); }), "cannot-edit");
  const std::string wide =
      "terrazzo: 1\nnodes:\n  \"é€\": {type: X, doc: \"日本語\", params: {'p': \"ü\"}} # ß\n";
  EXPECT_EQ(after(set("é€", "p", "2"), wide), replaced(wide, "\"ü\"", "2"));
  const std::string windows = "terrazzo: 1\r\nnodes:\r\n  a:\r\n    type: X\r\n    params:\r\n      p: 1\r\n";
  EXPECT_EQ(after(set("a", "p", "2"), windows), replaced(windows, "p: 1", "p: 2"));
  const std::string literal =
      "terrazzo: 1\nnodes:\n  a:\n    type: X\n    params:\n      p: |\n        x\n        y\n      q: 1\n";
  EXPECT_EQ(after(set("a", "p", "2"), literal), replaced(literal, "|\n        x\n        y\n", "2\n"));
  EXPECT_EQ(test::code_of([] { after(set("a", "p", "2"), "terrazzo: 1\nnodes: {a: {}}"); }), "cannot-edit");
  EXPECT_EQ(test::code_of([] { after(set("sgment", "p", "2")); }), "unknown-node");
  EXPECT_EQ(test::code_of([] { after({.kind = Kind::AddNode, .node = "pack", .type = "X"}); }), "name-taken");
  EXPECT_EQ(test::code_of([] { after({.kind = Kind::AddNode, .node = "a.b", .type = "X"}); }), "bad-name");
}

TEST(EditDocument, NodesAreBypassedAndBack) {
  const Edit on{.kind = Kind::SetBypass, .node = "segment", .bypass = true},
      off{.kind = Kind::SetBypass, .node = "segment"};
  const std::string text = after(on);
  EXPECT_NE(text.find("    bypass: true\n"), std::string::npos) << text;
  EXPECT_EQ(after(off, text), kGraph);
  EXPECT_EQ(after(off), kGraph);
}

}  // namespace
}  // namespace terrazzo
