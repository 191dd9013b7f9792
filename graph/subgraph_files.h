// The files of subgraphs, each read once however often it is used, and what a graph grows to when they are
// opened.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "graph/raw_document.h"

namespace terrazzo {

// A graph that expands to more nodes, or nests its subgraphs deeper, is refused before it is built.
inline constexpr std::uint64_t max_expanded_nodes = 100'000;
inline constexpr int max_nesting = 32;

struct SubgraphFile {
  std::optional<RawDocument> doc;   // none if the file cannot be read
  Diagnostics found;                // mistakes in the file itself
  std::set<std::string> recursive;  // its nodes whose graph is the file itself or one that uses it
  std::uint64_t nodes = 0;          // that it expands to; a subgraph's own node counts as well
  int nesting = 0;                  // levels of subgraphs below it
};

// The nodes and levels that a node stands for: 1 and 0 unless it is a subgraph.
struct Expansion {
  std::uint64_t nodes = 1;
  int nesting = 0;
};

class SubgraphFiles {
 public:
  // Reads the files that the document uses, and those that they use.
  explicit SubgraphFiles(const RawDocument& root);

  const SubgraphFile& root() const { return root_; }  // without a copy of the document
  // The file of a subgraph node of `doc`, which is the root or came from here.
  const SubgraphFile& open(const RawDocument& doc, const RawNode&) const;
  Expansion expansion(const RawDocument& doc, const RawNode&) const;

 private:
  // `level`: of the document below the root.
  void count(const RawDocument& doc, SubgraphFile& into, int level);

  std::map<std::filesystem::path, SubgraphFile> files_;
  std::set<std::filesystem::path> around_;  // the files being counted
  SubgraphFile root_;
};

}  // namespace terrazzo
