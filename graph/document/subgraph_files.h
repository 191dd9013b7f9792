// Subgraph files, each read once even if used many times, and the size of the graph after expansion.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "graph/document/raw_document.h"

namespace terrazzo {

// A graph that exceeds these limits is rejected before it is built.
inline constexpr std::uint64_t kMaxExpandedNodes = 100'000;
inline constexpr std::size_t kMaxExpandedWires = 2'000'000;
inline constexpr int kMaxNesting = 32;
inline constexpr std::uint64_t kMaxExpandedBytes = 1 << 30;  // of everything written in the nodes

struct SubgraphFile {
  std::optional<RawDocument> doc;   // none if the file cannot be read
  Diagnostics found;                // errors in the file itself
  std::set<std::string> recursive;  // nodes whose graph is this file or one that uses it
  // Number of nodes after expansion, subgraph nodes included. Repeated nodes count once.
  std::uint64_t nodes = 0;
  std::uint64_t bytes = 0;  // that these nodes take as text, estimated
  int nesting = 0;          // levels of subgraphs below it
};

// What a node expands to. Nodes and levels are 1 and 0 unless it is a subgraph.
struct Expansion {
  std::uint64_t nodes = 1;
  std::uint64_t bytes = 0;
  int nesting = 0;
};

class SubgraphFiles {
 public:
  // Reads the files that the document uses, directly or through other files. `texts`: see Overrides::files.
  explicit SubgraphFiles(const RawDocument& root,
                         const std::map<std::filesystem::path, std::string>& texts = {});

  const SubgraphFile& root() const { return root_; }  // its `doc` is empty
  // The file of a subgraph node of `doc`. `doc` is the root document or one returned by open().
  const SubgraphFile& open(const RawDocument& doc, const RawNode&) const;
  Expansion expansion(const RawDocument& doc, const RawNode&) const;

 private:
  // `level`: depth of the document below the root.
  void count(const RawDocument& doc, SubgraphFile& into, int level);
  std::optional<std::string> text_of(const std::filesystem::path& file, Diagnostics& found) const;

  const std::map<std::filesystem::path, std::string> texts_;
  std::map<std::filesystem::path, SubgraphFile> files_;
  std::set<std::filesystem::path> around_;  // the files being counted, to detect recursion
  SubgraphFile root_;
};

}  // namespace terrazzo
