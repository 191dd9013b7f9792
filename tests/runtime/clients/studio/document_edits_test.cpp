// Ten thousand random edits of all graphs in the repository.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "graph/document/write_document.h"
#include "graph/document/yaml_tree.h"
#include "runtime/clients/studio/live/document.h"
#include "tests/runtime/clients/studio/random_edits.h"
#include "tests/support/program.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using Kind = Edit::Kind;
using studio::Document;
using test::intended;
using test::names;

constexpr std::size_t kEdits = 10000;

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> out{""};
  for (const char c : text) {
    out.back() += c;
    if (c == '\n') out.emplace_back();
  }
  return out;
}

// A text with what tells which of its lines an edit may change.
class Text {
 public:
  Text(const std::string& text, const fs::path& file)
      : lines_(split_lines(text)), tree_(*read_yaml_tree(text)) {
    Diagnostics found;
    doc = read_document(text, file, found);
    EXPECT_FALSE(has_errors(found)) << file << "\n" << text;
    std::size_t at = 0;
    for (const auto& line : lines_) {
      starts_.push_back(at);
      at += line.size();
    }
  }

  // Whether `now` differs from the text in the edit's own lines only.
  bool owns(const Edit& e, const std::string& now) {
    own_.clear();
    const YamlNode* node = find({"nodes", e.node});
    switch (e.kind) {
      case Kind::SetParameter:
      case Kind::ResetParameter:
      case Kind::AppendItem:
      case Kind::RemoveItem:
        entry({"nodes", e.node, "params", e.name}, node);
        break;
      case Kind::Connect:
        entry({"nodes", e.node, "inputs", e.name}, node);
        break;
      case Kind::SetDefault:
        entry({"parameters", e.name, "default"}, find({"parameters", e.name}));
        break;
      case Kind::SetBypass:
        entry({"nodes", e.node, "bypass"}, node);
        break;
      case Kind::SetSubgraph:
        entry({"nodes", e.node, "graph"}, node);
        break;
      case Kind::AddNode:
        add(line_of(find({"nodes"})->end));
        break;
      case Kind::Rewire:
        wires([&](const std::string& w) { return w == e.name; });
        break;
      case Kind::RemoveNode:
        entry({"nodes", e.node}, nullptr);
        [[fallthrough]];
      case Kind::RenameNode:
        wires([&](const std::string& w) { return names(w, e.node); });
        add(line_of(key({"nodes", e.node})->begin));
        break;
    }
    std::size_t at = 0;  // all other lines are there, in their order
    const auto after = split_lines(now);
    for (std::size_t k = 0; k < lines_.size(); ++k) {
      if (own_.contains(k)) continue;
      while (at < after.size() && after[at] != lines_[k]) ++at;
      if (at++ == after.size()) return false;
    }
    return true;
  }

  RawDocument doc;

 private:
  using Path = std::vector<std::string>;
  const YamlEntry* entry_at(const Path& path) const {
    const YamlNode* map = &tree_;
    const YamlEntry* out = nullptr;
    for (const auto& key : path) {
      const auto it = std::ranges::find_if(map->entries, [&](const auto& e) { return e.first.text == key; });
      if (it == map->entries.end()) return nullptr;
      out = &*it;
      map = &it->second;
    }
    return out;
  }
  const YamlNode* find(const Path& path) const {
    const auto* e = entry_at(path);
    return e ? &e->second : nullptr;
  }
  const YamlNode* key(const Path& path) const { return &entry_at(path)->first; }
  std::size_t line_of(std::size_t byte) const {
    return static_cast<std::size_t>(std::ranges::upper_bound(starts_, byte) - starts_.begin()) - 1;
  }
  void add(std::size_t line) { own_.insert(line); }
  // The lines of an entry, and of the mapping around it if it is the only one. If there is no such entry, the
  // line to which it may be added.
  void entry(Path path, const YamlNode* otherwise) {
    const auto* e = entry_at(path);
    if (!e) {
      path.pop_back();
      const YamlNode* around = find(path);
      if (const YamlNode* at = around ? around : otherwise)
        add(line_of(at->end > at->begin ? at->end - 1 : at->end));
      if (around) add(line_of(key(path)->begin));  // `params:` without a value
      return;
    }
    for (std::size_t k = line_of(e->first.begin); k <= line_of(std::max(e->first.end, e->second.end) - 1);
         ++k)
      add(k);
    path.pop_back();
    if (!path.empty() && path.back() != "nodes" && find(path)->entries.size() == 1) entry(path, nullptr);
  }
  template <class Is>
  void wires(Is&& is) {
    std::size_t gone = 0;
    for (const auto& n : doc.nodes) {
      for (const auto& [port, list] : n.inputs)
        if (std::ranges::any_of(list, [&](const auto& w) { return is(w.text); }))
          entry({"nodes", n.name, "inputs", port}, nullptr), ++gone;
      if (gone > 0 && gone == n.inputs.size()) entry({"nodes", n.name, "inputs"}, nullptr);
      gone = 0;
    }
    for (const auto& [port, w] : doc.outputs)
      if (is(w.text)) entry({"outputs", port}, nullptr), ++gone;
    if (gone > 0 && gone == doc.outputs.size()) entry({"outputs"}, nullptr);
    for (const auto& [port, w] : doc.inputs)
      if (is(w.text)) entry({"inputs", port}, nullptr);
  }

  std::vector<std::string> lines_;
  std::vector<std::size_t> starts_;
  YamlNode tree_;
  std::set<std::size_t> own_;
};

TEST(StudioDocumentEdits, TenThousandChangeTheirOwnLinesAndAreUndone) {
  std::vector<fs::path> files;
  for (const char* folder : {"graphs", "nodes"})
    for (const auto& e : fs::recursive_directory_iterator(test::source_folder() / folder))
      if (e.path().extension() == ".yaml") files.push_back(e.path());
  std::sort(files.begin(), files.end());
  ASSERT_GT(files.size(), 80u);
  const std::size_t each = (kEdits + files.size() - 1) / files.size();
  test::RandomEdits random;
  std::map<Kind, int> done;
  int subgraphs = 0, repeated = 0;
  std::map<std::string, int> refused;
  for (const auto& file : files) {
    Document document(file, /*read_only=*/true);
    std::vector<std::string> texts{document.text()};
    for (std::size_t k = 0; k < each; ++k) {
      Text before(document.text(), file);
      const Edit e = random.next(before.doc, k);
      const auto what = [&] {
        return file.string() + ", edit " + std::to_string(k) + " of kind " +
               std::to_string(static_cast<int>(e.kind)) + ": " + e.node + "." + e.name + "\n" + texts.back() +
               "\n--- now\n" + document.text();
      };
      try {
        document.edit({e});
      } catch (const Error& error) {
        ASSERT_EQ(document.text(), texts.back());
        ++refused[error.diagnostic().code + " " + std::to_string(static_cast<int>(e.kind)) + " " +
                  e.value.text() + e.graph];
        continue;
      }
      Diagnostics found;
      const RawDocument after = read_document(document.text(), file, found);
      ASSERT_FALSE(has_errors(found)) << what();
      ASSERT_TRUE(same_document(after, intended(before.doc, e))) << what();
      ASSERT_TRUE(before.owns(e, document.text())) << what();
      ++done[e.kind];
      if (const auto n = std::ranges::find(before.doc.nodes, e.node, &RawNode::name);
          n != before.doc.nodes.end())
        subgraphs += !n->graph.empty(), repeated += !n->each.empty();
      if (document.text() != texts.back()) texts.push_back(document.text());
    }
    for (std::size_t k = texts.size(); k-- > 0;) {
      ASSERT_EQ(document.text(), texts[k]) << file;
      ASSERT_EQ(document.undo(), k > 0) << file;
    }
    for (std::size_t k = 1; k < texts.size(); ++k) ASSERT_TRUE(document.redo());
    ASSERT_EQ(document.text(), texts.back());
  }
  int all = 0;
  for (const auto& [kind, count] : done) {
    all += count;
    EXPECT_GT(count, 100) << static_cast<int>(kind);
  }
  EXPECT_EQ(done.size(), 12u);
  EXPECT_GT(subgraphs, 100);
  EXPECT_GT(repeated, 10);
  for (const auto& [why, count] : refused) EXPECT_EQ(count, 0) << why;
  EXPECT_GE(all, static_cast<int>(kEdits));
}

}  // namespace
}  // namespace terrazzo
