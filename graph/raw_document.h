// A graph file as it is written: YAML read into plain structures, each with its place. Knows no node types.
#pragma once

#include <filesystem>
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

RawDocument read_document(const std::string& text, const std::filesystem::path& file, Diagnostics& found);

// A value from the command line: a scalar or a flow list. Throws Error "bad-value".
WrittenValue read_written(const std::string& text);

}  // namespace terrazzo
