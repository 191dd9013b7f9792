// Edits of graph files change their own lines and nothing else.
#include "graph/edit_document.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "graph/raw_document.h"
#include "graph/yaml_tree.h"
#include "runtime/files.h"
#include "tests/support/code_of.h"
#include "tests/support/program.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
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

std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

Edit set(const std::string& node, const std::string& name, const std::string& value) {
  return {Kind::SetParameter, node, name, {false, {value}, {}}};
}

TEST(EditDocument, ParametersChangeInPlace) {
  EXPECT_EQ(after(set("segment", "min_area", "30")), with(kGraph, "min_area: 20", "min_area: 30"));
  EXPECT_EQ(after(set("photo", "path", "b c.png")), with(kGraph, "a.png", "b c.png"));
  EXPECT_EQ(after({Kind::SetParameter, "segment", "classes", {true, {"x"}, {}}}),
            with(kGraph, "[a,\n        b]", "[x]"));
  EXPECT_EQ(after({Kind::SetDefault, "", "size", {true, {"1", "2", "3"}, {}}}),
            with(kGraph, "default: 40", "default: [1, 2, 3]"));
}

TEST(EditDocument, ParametersAreAdded) {
  EXPECT_EQ(after(set("photo", "scale", "2")), with(kGraph, "a.png}", "a.png, scale: 2}"));
  EXPECT_EQ(after(set("segment", "seed", "${seed}")),
            with(kGraph, "        b]\n", "        b]\n      seed: \"${seed}\"\n"));
  EXPECT_EQ(after(set("pack", "seed", "3")),
            with(kGraph, "photo.image]}\n", "photo.image]}\n    params: {seed: 3}\n"));
  EXPECT_EQ(after(set("a", "b", "c"), "terrazzo: 1\nnodes: {a: {type: X}}"),
            "terrazzo: 1\nnodes: {a: {type: X, params: {b: c}}}");
  EXPECT_EQ(after(set("a", "b", "c"), "terrazzo: 1\nnodes:\n  a:\n    type: X\n    params:"),
            "terrazzo: 1\nnodes:\n  a:\n    type: X\n    params: {b: c}");
}

TEST(EditDocument, ParametersAreReset) {
  EXPECT_EQ(after({Kind::ResetParameter, "segment", "min_area"}),
            with(kGraph, "      min_area: 20  # pixels\n", ""));
  EXPECT_EQ(after({Kind::ResetParameter, "photo", "path"}), with(kGraph, ", params: {path: a.png}", ""));
  EXPECT_EQ(after({Kind::ResetParameter, "photo", "nothing"}), kGraph);
}

TEST(EditDocument, WiresAreConnectedAndRemoved) {
  EXPECT_EQ(after({Kind::Connect, "segment", "image", {}, {"photo.other"}}),
            with(kGraph, "image: photo.image\n", "image: photo.other\n"));
  EXPECT_EQ(after({Kind::Connect, "segment", "image"}),
            with(kGraph, "    inputs:\n      image: photo.image\n", ""));
  EXPECT_EQ(after({Kind::Connect, "pack", "extra", {}, {"segment.labels"}}),
            with(kGraph, "[segment.labels, photo.image]", "segment.labels"));
  EXPECT_EQ(after({Kind::Connect, "photo", "in", {}, {"pack.a", "pack.b"}}),
            with(kGraph, "a.png}}", "a.png}, inputs: {in: [pack.a, pack.b]}}"));
}

TEST(EditDocument, NodesAreAddedRemovedAndRenamed) {
  EXPECT_EQ(after({.kind = Kind::AddNode, .node = "sheet", .type = "ContactSheet"}),
            with(kGraph, "outputs:", "  sheet:\n    type: ContactSheet\noutputs:"));
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
            with(with(with(kGraph, "  photo:", "  picture:"), "image: photo.image", "image: picture.image"),
                 ", photo.image]", ", picture.image]"));
}

TEST(EditDocument, ItemsAreAppendedAndRemoved) {
  const auto append = [](const std::string& node, const std::string& name, const std::string& item) {
    return Edit{Kind::AppendItem, node, name, {false, {item}, {}}};
  };
  const std::string flow = with(kGraph, "        b]", "        b, split 1 2 3 4]");
  EXPECT_EQ(after(append("segment", "classes", "split 1 2 3 4")), flow);
  EXPECT_EQ(after({.kind = Kind::RemoveItem, .node = "segment", .name = "classes", .index = 0}, flow),
            with(flow, "[a,\n        b, split", "[b, split"));
  EXPECT_EQ(after({.kind = Kind::RemoveItem, .node = "segment", .name = "classes", .index = 2}, flow),
            kGraph);
  const std::string one =
      with(kGraph, "photo.image]}\n", "photo.image]}\n    params:\n      edits:\n        - delete 1 2\n");
  EXPECT_EQ(after(append("pack", "edits", "delete 1 2")), one);
  const std::string noted = with(one, "delete 1 2\n", "delete 1 2  # a speck\n        # more\n");
  const std::string two = with(noted, "a speck\n", "a speck\n        - \"1: merge 1 2, 3 4\"\n");
  EXPECT_EQ(after(append("pack", "edits", "1: merge 1 2, 3 4"), noted), two);
  EXPECT_EQ(after({.kind = Kind::RemoveItem, .node = "pack", .name = "edits", .index = 1}, two), noted);
  EXPECT_EQ(after({.kind = Kind::RemoveItem, .node = "pack", .name = "edits", .index = 0}, noted),
            with(noted, "    params:\n      edits:\n        - delete 1 2  # a speck\n", ""));
  EXPECT_EQ(after(append("photo", "path", "b.png")), with(kGraph, "path: a.png", "path: [b.png]"));
  EXPECT_EQ(test::code_of(
                [] { after({.kind = Kind::RemoveItem, .node = "segment", .name = "classes", .index = 2}); }),
            "unknown-item");
}

TEST(EditDocument, ConsumersAreRewired) {
  EXPECT_EQ(after({.kind = Kind::Rewire, .node = "x", .name = "segment.profiles", .to = "measure.profiles"}),
            with(with(kGraph, "{profiles: segment.profiles, extra", "{profiles: measure.profiles, extra"),
                 "outputs: {profiles: segment.profiles}", "outputs: {profiles: measure.profiles}"));
  EXPECT_EQ(after({.kind = Kind::Rewire, .node = "segment", .name = "photo.image", .to = "a.b"}),
            with(kGraph, "segment.labels, photo.image", "segment.labels, a.b"));
  EXPECT_EQ(after({.kind = Kind::SetSubgraph, .node = "a", .graph = "../b.yaml"},
                  "terrazzo: 1\nnodes: {a: {graph: b.yaml}}"),
            "terrazzo: 1\nnodes: {a: {graph: ../b.yaml}}");
}

TEST(EditDocument, OddTextIsKeptOrRefused) {
  const std::string shared =
      "terrazzo: 1\nnodes:\n  a: {type: X, params: {p: &v 1}}\n  b: {type: X, params: {p: *v}}\n";
  EXPECT_EQ(after(set("b", "p", "2"), shared), with(shared, "*v", "2"));
  // The anchor's value is also b's, so the edit would change both.
  EXPECT_EQ(test::code_of([&] { after(set("a", "p", "2"), shared); }), "cannot-edit");
  const std::string merged = "terrazzo: 1\nnodes:\n  a: &a {type: X, params: {p: 1}}\n  b: *a\n";
  EXPECT_EQ(test::code_of([&] { after(set("b", "p", "2"), merged); }), "cannot-edit");
  const std::string wide =
      "terrazzo: 1\nnodes:\n  \"é€\": {type: X, doc: \"日本語\", params: {'p': \"ü\"}} # ß\n";
  EXPECT_EQ(after(set("é€", "p", "2"), wide), with(wide, "\"ü\"", "2"));
  const std::string windows = "terrazzo: 1\r\nnodes:\r\n  a:\r\n    type: X\r\n    params:\r\n      p: 1\r\n";
  EXPECT_EQ(after(set("a", "p", "2"), windows), with(windows, "p: 1", "p: 2"));
  const std::string literal =
      "terrazzo: 1\nnodes:\n  a:\n    type: X\n    params:\n      p: |\n        x\n        y\n      q: 1\n";
  EXPECT_EQ(after(set("a", "p", "2"), literal), with(literal, "|\n        x\n        y\n", "2\n"));
  EXPECT_EQ(test::code_of([] { after(set("a", "p", "2"), "terrazzo: 1\nnodes: {a: {}}"); }), "cannot-edit");
  EXPECT_EQ(test::code_of([] { after(set("sgment", "p", "2")); }), "unknown-node");
  EXPECT_EQ(test::code_of([] { after({.kind = Kind::AddNode, .node = "pack", .type = "X"}); }), "name-taken");
  EXPECT_EQ(test::code_of([] { after({.kind = Kind::AddNode, .node = "a.b", .type = "X"}); }), "bad-name");
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> out{""};
  for (const char c : text) {
    out.back() += c;
    if (c == '\n') out.emplace_back();
  }
  return out;
}

// The lines that differ, after equal lines at both ends are left out.
std::size_t changed_lines(const std::string& before, const std::string& now) {
  const auto a = lines(before), b = lines(now);
  std::size_t top = 0, bottom = 0;
  while (top < std::min(a.size(), b.size()) && a[top] == b[top]) ++top;
  while (bottom < std::min(a.size(), b.size()) - top && a[a.size() - 1 - bottom] == b[b.size() - 1 - bottom])
    ++bottom;
  return std::max(a.size(), b.size()) - top - bottom;
}

// The lines from the key of an entry to the end of its value.
std::size_t lines_of(const YamlNode& root, const std::vector<std::string>& path, const std::string& text) {
  const YamlNode* map = &root;
  std::size_t begin = 0;
  for (const auto& key : path)
    for (const auto& [k, v] : map->entries)
      if (k.text == key) {
        begin = k.begin, map = &v;
        break;
      }
  return lines(text.substr(begin, map->end - begin)).size();
}

std::vector<fs::path> every_graph() {
  std::vector<fs::path> files;
  for (const char* folder : {"graphs", "nodes"})
    for (const auto& e : fs::recursive_directory_iterator(test::source_folder() / folder))
      if (e.path().extension() == ".yaml") files.push_back(e.path());
  std::sort(files.begin(), files.end());
  return files;
}

// Random edits of every graph in the repository. edit_document() itself compares the result with the intended
// document, so this checks which lines change.
TEST(EditDocument, RandomEditsOfEveryGraphChangeTheirOwnLines) {
  const auto files = every_graph();
  ASSERT_GT(files.size(), 80u);
  std::mt19937 random(1);
  std::size_t edits = 0;
  for (const auto& file : files) {
    const std::string text = *read_file(file);
    Diagnostics found;
    const RawDocument doc = read_document(text, file, found);
    if (has_errors(found) || doc.nodes.empty()) continue;
    const auto tree = read_yaml_tree(text);
    ASSERT_TRUE(tree) << file;
    for (int k = 0; k < 60; ++k, ++edits) {
      const RawNode& node = doc.nodes[random() % doc.nodes.size()];
      Edit e{Kind::SetParameter, node.name, "new_" + std::to_string(k), {false, {"-1.5e3 # \"x\": y"}, {}}};
      std::size_t most = 1;
      if (!node.params.empty() && random() % 4) {
        e.name = node.params[random() % node.params.size()].first;
        if (random() % 4 == 0) e.kind = Kind::ResetParameter;
        if (random() % 3 == 0) e.value = {true, {"1", "a b", "", "${x}"}, {}};
        most = lines_of(*tree, {"nodes", node.name, "params", e.name}, text);
        most += e.kind == Kind::ResetParameter && node.params.size() == 1;  // the line of `params:`
      } else if (!node.inputs.empty() && random() % 2) {
        e.kind = Kind::Connect, e.name = node.inputs[random() % node.inputs.size()].first;
        if (random() % 2) e.wires = {doc.nodes.front().name + ".x", "a.b"};
        most = lines_of(*tree, {"nodes", node.name, "inputs", e.name}, text);
        most += e.wires.empty() && node.inputs.size() == 1;
      }
      std::string now;
      ASSERT_NO_THROW(now = edit_document(text, file, e)) << file << " " << e.node << "." << e.name;
      EXPECT_NE(now, text);
      EXPECT_LE(changed_lines(text, now), most) << file << " " << e.node << "." << e.name;
    }
  }
  EXPECT_GE(edits, 5000u);
}

// Long series of edits, each on the result of the one before: nodes come and go, are renamed and wired.
TEST(EditDocument, SeriesOfEditsKeepEveryComment) {
  std::mt19937 random(2);
  const auto comments = [](const std::string& text) {
    std::vector<std::string> out;
    for (const auto& line : lines(text))
      if (const auto at = line.find_first_not_of(' '); at != std::string::npos && line[at] == '#')
        out.push_back(line);
    return out;
  };
  std::size_t edits = 0;
  for (const auto& file : every_graph()) {
    std::string text = *read_file(file);
    const auto before = comments(text);
    for (int k = 0; k < 12; ++k, ++edits) {
      Diagnostics found;
      const RawDocument doc = read_document(text, file, found);
      ASSERT_FALSE(has_errors(found)) << file;
      const std::string node = doc.nodes[random() % doc.nodes.size()].name,
                        fresh = "node_" + std::to_string(k);
      const Edit all[] = {
          {.kind = Kind::AddNode, .node = fresh, .type = "Section"},
          {.kind = Kind::RenameNode, .node = node, .to = fresh},
          {.kind = Kind::Connect, .node = node, .name = "in", .wires = {node + ".out"}},
          {.kind = Kind::SetParameter, .node = node, .name = "x", .value = {false, {"1"}, {}}}};
      ASSERT_NO_THROW(text = edit_document(text, file, all[random() % 4])) << file << " " << node << "\n"
                                                                           << text;
    }
    EXPECT_EQ(comments(text), before) << file;
  }
  EXPECT_GE(edits, 1000u);
}

}  // namespace
}  // namespace terrazzo
