// Nodes that are pasted as text.
#include "graph/document/paste_nodes.h"

#include <gtest/gtest.h>

#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

using CopiedNames = std::vector<std::pair<std::string, std::string>>;

const std::string kPasteTarget =
    "terrazzo: 1\nnodes:\n  photo: {type: LoadImage, params: {path: a.png}}  # mine\n  blur:\n    type: "
    "Blur\n"
    "    inputs: {image: photo.image}  # kept\n\noutputs: {image: blur.image}\n";

Pasted pasted_into(const std::string& nodes, const std::string& text = kPasteTarget) {
  return paste_nodes(text, "graph.yaml", nodes);
}

std::string target_with(const std::string& lines) {
  std::string out = kPasteTarget;
  return out.insert(out.find("\noutputs"), lines);
}

TEST(PasteNodes, KeepsTheirLinesAndRenamesThem) {
  const Pasted p = pasted_into("  blur:\n    type: Blur\n    inputs: {image: photo.image}  # kept\n");
  EXPECT_EQ(p.text, target_with("  blur_2:\n    type: Blur\n    inputs: {image: photo.image}  # kept\n"));
  EXPECT_EQ(p.names, (CopiedNames{{"blur", "blur_2"}}));
  EXPECT_EQ(paste_nodes(p.text, "graph.yaml", "blur_2: {type: Blur}").names,
            (CopiedNames{{"blur_2", "blur_3"}}));
}

TEST(PasteNodes, WiresBetweenThemFollowAndOthersAreKeptIfTheyCan) {
  const Pasted p = pasted_into(
      "photo: {type: LoadImage}\r\nmix:   # two\r\n  type: Mix\r\n  each: {k: [photo]}\r\n  doc: both\r\n"
      "  inputs: {a: photo.image, b: [blur.image, gone.image], c: gone, d: \"${k}.image\"}\r\n");
  EXPECT_EQ(
      p.text,
      target_with("  photo_2: {type: LoadImage}\n  mix:   # two\n    type: Mix\n    each: {k: [photo]}\n"
                  "    doc: both\n    inputs: {a: photo_2.image, b: blur.image, d: \"${k}.image\"}\n"));
  EXPECT_EQ(p.names, (CopiedNames{{"photo", "photo_2"}, {"mix", "mix"}}));
}

TEST(PasteNodes, TakenNamesAmongThemAreNotGivenTwice) {
  EXPECT_EQ(pasted_into("blur: {type: Blur}\nblur_2: {type: Blur, inputs: {image: blur.image}}\n").names,
            (CopiedNames{{"blur", "blur_3"}, {"blur_2", "blur_2"}}));
}

TEST(PasteNodes, AWholeFileGivesItsNodes) {
  const Pasted p = pasted_into(kPasteTarget);
  EXPECT_EQ(
      p.text,
      target_with("  photo_2: {type: LoadImage, params: {path: a.png}}  # mine\n  blur_2:\n    type: Blur\n"
                  "    inputs: {image: photo_2.image}  # kept\n"));
  EXPECT_EQ(pasted_into("nodes:\n  a: {type: T}\n").text, target_with("  a: {type: T}\n"));
}

TEST(PasteNodes, AnEmptyGraphTakesThemToo) {
  EXPECT_EQ(pasted_into("a:\n  type: T\nb: {type: T}", "terrazzo: 1\nnodes: {}  # none\nname: N\n").text,
            "terrazzo: 1\nnodes: \n  a:\n    type: T\n  b: {type: T}  # none\nname: N\n");
}

TEST(PasteNodes, OtherTextIsRefused) {
  for (const char* text : {"", "Dear colleague", "- a\n- b", "a: 1", "a: {tipe: T}", "a: {type: T",
                           "a:\n\ttype: T", "a: *b", "terrazzo: 2\nnodes: {a: {type: T}}", "nodes: {}"})
    EXPECT_EQ(test::code_of([&] { pasted_into(text); }), "no-nodes") << text;
  EXPECT_EQ(test::code_of([&] { pasted_into("{a: {type: T}}"); }), "cannot-edit");
  EXPECT_EQ(test::code_of([&] { pasted_into("nodes: {a: {type: T}}"); }), "cannot-edit");
  EXPECT_EQ(test::code_of([&] { pasted_into("a: {type: T}", "terrazzo: 1\nnodes: {b: {type: T}}\n"); }),
            "cannot-edit");
  std::string many;
  for (int k = 0; k < 501; ++k) many += "n" + std::to_string(k) + ": {type: T}\n";
  EXPECT_EQ(test::code_of([&] { pasted_into(many); }), "too-large");
}

}  // namespace
}  // namespace terrazzo
