#include "graph/document/write_document.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "graph/graph.h"
#include "tests/support/arithmetic.h"
#include "tests/support/replaced.h"

namespace terrazzo {
namespace {
using test::replaced;

RawDocument document_of(const std::string& text) {
  Diagnostics found;
  RawDocument doc = read_document(text, "test.yaml", found);
  for (const auto& d : found) ADD_FAILURE() << d.text() << "\n" << text;
  return doc;
}

const char* const kText =
    "# About the graph.\n"
    "terrazzo: 1\n"
    "name: Sums  # of numbers\n"
    "parameters:\n"
    "  # The first number.\n"
    "  first: {type: number, default: 2, doc: \"First: a number\"}\n"
    "\n"
    "  second: {type: number, default: 3, min: 0.000001}\n"
    "nodes:\n"
    "  a: {type: Constant, params: {value: \"${first}\"}}  # flow\n"
    "  # Two lines\n"
    "  # about b.\n"
    "  b:\n"
    "    type: Constant\n"
    "    params: {value: \"${second}\"}  # with a comment\n"
    "  sum:\n"
    "    type: Add\n"
    "    inputs: {a: a.out, b: b.out}\n"
    "outputs: {sum: sum.out}\n";

TEST(WriteDocument, KeepsTheTextOfADocumentThatDidNotChange) {
  EXPECT_EQ(write_document(document_of(kText), kText), kText);
}

TEST(WriteDocument, WritesOnlyWhatChanged) {
  RawDocument doc = document_of(kText);
  doc.nodes[1].params[0].second.written.items[0] = "7";
  doc.parameters[1].value.written.items[0] = "4";
  RawNode node;
  node.name = "c";
  node.type = "Constant";
  doc.nodes.push_back(node);
  EXPECT_EQ(write_document(doc, kText), replaced(replaced(replaced(kText, "default: 3", "default: 4"),
                                                          "\"${second}\"}  # with a comment", "7}"),
                                                 "outputs:", "  c:\n    type: Constant\noutputs:"));
  doc = document_of(kText);
  doc.nodes.erase(doc.nodes.begin());
  doc.outputs.clear();
  doc.inputs.push_back({"b", {"b.out", {}}});
  const std::string text = write_document(doc, kText);
  EXPECT_EQ(text.find("flow"), std::string::npos);
  EXPECT_EQ(text.find("outputs"), std::string::npos);
  EXPECT_NE(text.find("  # Two lines\n  # about b.\n  b:\n"), std::string::npos) << text;
  EXPECT_NE(text.find("inputs:\n  b: b.out\n"), std::string::npos) << text;
}

TEST(WriteDocument, WritesAnewWhatCannotBePatched) {
  for (const std::string text :
       {"{terrazzo: 1, nodes: {a: {type: Constant}, b: {type: Constant}}}\n",
        "terrazzo: 1\nnodes: {a: {type: Constant}, b: {type: Constant}}\n",
        "terrazzo: 1\nnodes:\n  {a: {type: Constant},\n   b: {type: Constant}}\n",
        "nodes:\n  a: {type: Constant}\n  b: {type: Constant}\nterrazzo: 1",
        "terrazzo: 1\nname: \"two\n\nnodes: lines\"\nnodes:\n  a: &x {type: Constant}\n  b: *x\n"}) {
    RawDocument doc = document_of(text);
    EXPECT_TRUE(same_document(document_of(write_document(doc, text)), doc)) << text;
    doc.nodes[0].doc = "changed";
    doc.nodes.pop_back();
    const std::string written = write_document(doc, text);
    EXPECT_TRUE(same_document(document_of(written), doc)) << text << "\n" << written;
  }
}

TEST(WriteDocument, QuotesWhatYamlWouldReadDifferently) {
  for (const std::string word : {"",
                                 " ",
                                 "~",
                                 "null",
                                 "-",
                                 "- a",
                                 "-1",
                                 "a: b",
                                 "a:",
                                 "a #b",
                                 "#a",
                                 "${x}",
                                 "[a",
                                 "a, b",
                                 "'",
                                 "\"",
                                 "\\",
                                 "a\nb",
                                 "\t",
                                 "é",
                                 "5 × 5",
                                 "?",
                                 "? a",
                                 "*a",
                                 "&a",
                                 "!a",
                                 "%a",
                                 "@a",
                                 "`a",
                                 "|",
                                 ">",
                                 "...",
                                 "---",
                                 "<<",
                                 "=",
                                 "true",
                                 "1e3",
                                 "a\x01"
                                 "b",
                                 "\xc2\x85",
                                 "\xe2\x80\xa8",
                                 "\xef\xbb\xbf",
                                 "a'b",
                                 "a\"b",
                                 ": a",
                                 ":a",
                                 "\x7f",
                                 "a b ",
                                 "http://a/b#c"}) {
    RawDocument doc;
    doc.name = "x" + word;
    RawNode node;
    node.name = "a";
    node.type = "Constant";
    node.doc = word;
    node.params.push_back({"value", {{false, {word}, {}}, {}}});
    node.params.push_back({"list", {{true, {word, "b", word}, {}}, {}}});
    doc.nodes.push_back(node);
    RawParameter p;
    p.declaration.name = "p";
    p.declaration.kind = ParameterKind::Text;
    p.declaration.doc = word;
    p.value.written = {false, {word}, {}};
    doc.parameters.push_back(p);
    EXPECT_TRUE(same_document(document_of(write_document(doc)), doc)) << write_document(doc);
  }
}

// Random documents, random edits: the text always reads back as the document.
TEST(WriteDocument, RandomEditsReadBack) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    const auto pick = [&](unsigned n) { return static_cast<int>(random() % n); };
    RawDocument doc = document_of(kText);
    for (int edit = 0; edit < 6; ++edit) {
      switch (pick(7)) {
        case 0:
          if (!doc.nodes.empty())
            doc.nodes.erase(doc.nodes.begin() + pick(static_cast<unsigned>(doc.nodes.size())));
          break;
        case 1: {
          RawNode node;
          node.name = "n" + std::to_string(edit);
          node.type = "Constant";
          doc.nodes.insert(doc.nodes.begin() + pick(static_cast<unsigned>(doc.nodes.size()) + 1), node);
          break;
        }
        case 2:
          if (!doc.nodes.empty())
            doc.nodes[static_cast<std::size_t>(pick(static_cast<unsigned>(doc.nodes.size())))]
                .params.push_back(
                    {"p" + std::to_string(edit), {{pick(2) == 0, {"v: " + std::to_string(seed)}, {}}, {}}});
          break;
        case 3:
          doc.parameters.clear();
          break;
        case 4:
          doc.name = pick(2) ? "" : "# named";
          break;
        case 5:
          doc.outputs = {{"o", {"a.out", {}}}, {"p" + std::to_string(edit), {"b.out", {}}}};
          break;
        default:
          doc.doc = "text\nof lines";
      }
    }
    const std::string text = write_document(doc, kText);
    EXPECT_TRUE(same_document(document_of(text), doc)) << "seed " << seed << "\n" << text;
    EXPECT_EQ(write_document(doc, text), text);
  }
}

TEST(WriteDocument, ALinkedDocumentIsTheLoadedGraph) {
  const std::string text =
      "terrazzo: 1\nnodes:\n  a: {type: Constant, params: {value: 5}}\n  c: {type: Clamp, inputs: {in: "
      "a.out}}\n";
  Diagnostics found;
  const Graph loaded = load_graph_text(text, "test.yaml", test::arithmetic(), {}, found);
  const Graph linked = link_document(document_of(text), test::arithmetic(), {}, found);
  EXPECT_TRUE(found.empty());
  ASSERT_EQ(linked.paths(), loaded.paths());
  EXPECT_EQ(linked.nodes[0].parameters.at("value").value, loaded.nodes[0].parameters.at("value").value);
}

}  // namespace
}  // namespace terrazzo
