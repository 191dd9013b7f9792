// A graph file as written: YAML parsed into plain structures, each with its place. Independent of node types.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "graph/parameter.h"

namespace terrazzo {

struct RawValue {
  WrittenValue written;
  Place place;
};
struct RawReference {  // "segment.labels"
  std::string text;
  Place place;
};
struct RawNode {
  std::string name;
  Place place;
  std::string type, graph;  // exactly one is set
  std::string doc;
  bool bypass = false;  // what reads an output reads an input of its type instead, and the node does not run
  bool may_fail = false;  // if it fails, the nodes outside it go on without its outputs
  Place kind_place;       // of the value of `type:` or `graph:`
  // The names and values that the node is repeated for, each a list or a range.
  std::vector<std::pair<std::string, RawValue>> each = {};
  std::vector<std::pair<std::string, RawValue>> params;
  std::vector<std::pair<std::string, std::vector<RawReference>>> inputs;
};
struct RawParameter {
  Parameter declaration;
  RawValue value;  // the default as written; `items` is empty if there is none
  Place place;
};
struct RawDocument {
  std::filesystem::path file;
  std::string name, doc;
  std::vector<RawParameter> parameters;
  std::vector<RawNode> nodes;
  std::vector<std::pair<std::string, RawReference>> inputs, outputs;
};

// The format version that this program reads and writes.
inline constexpr int kGraphFormat = 1;

// Larger files are rejected, because they could exhaust memory. Values behind an alias count at each use.
inline constexpr std::size_t kMaxGraphBytes = std::size_t{16} << 20;
inline constexpr std::size_t kMaxGraphValues = 2'000'000;

// Reads a graph file as text. On failure, returns nothing and appends an error without a place to `found`.
std::optional<std::string> read_graph_text(const std::filesystem::path&, Diagnostics& found);

RawDocument read_document(const std::string& text, const std::filesystem::path& file, Diagnostics& found);

// Parses a value from the command line, a scalar or a flow list. Throws Error "bad-value".
WrittenValue read_written(const std::string& text);

}  // namespace terrazzo
