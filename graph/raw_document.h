// A graph file as it is written: YAML read into plain structures, each with its place. Knows no node types.
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
  std::string type, graph;  // one of the two
  Place kind_place;         // of `type:` or `graph:`
  std::vector<std::pair<std::string, RawValue>> params;
  std::vector<std::pair<std::string, std::vector<RawReference>>> inputs;
};
struct RawParameter {
  Parameter declaration;
  RawValue value;  // the default as written; `items` empty where there is none
  Place place;
};
struct RawDocument {
  std::filesystem::path file;
  std::string name, doc;
  std::vector<RawParameter> parameters;
  std::vector<RawNode> nodes;
  std::vector<std::pair<std::string, RawReference>> inputs, outputs;
};

// The version of the format that this program writes and reads.
inline constexpr int graph_format = 1;

// A file with more bytes or more values is refused, because it could take all memory. Values behind an alias
// count wherever they are used.
inline constexpr std::size_t max_graph_bytes = std::size_t{16} << 20;
inline constexpr std::size_t max_graph_values = 2'000'000;

// Reads a graph file as text. If there is no result, `found` says why, without a place.
std::optional<std::string> read_graph_text(const std::filesystem::path&, Diagnostics& found);

RawDocument read_document(const std::string& text, const std::filesystem::path& file, Diagnostics& found);

// A value from the command line: a scalar or a flow list. Throws Error "bad-value".
WrittenValue read_written(const std::string& text);

}  // namespace terrazzo
