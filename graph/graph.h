// Graph: a document, subgraphs unfolded, every name resolved. What the evaluator runs.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/diagnostic.h"
#include "graph/node_type.h"
#include "graph/registry.h"

namespace terrazzo {

struct Wire {
  int node = -1;  // index of the source
  std::string port;
  Place place;
};

struct SetParameter {
  ParameterValue value;
  Place place;  // where it was written; without line for the command line
  std::string as_written;
};

struct GraphNode {
  std::string path;  // "asset/pack"
  const NodeType* type = nullptr;
  Place place;
  std::map<std::string, SetParameter> parameters;   // written ones only
  std::map<std::string, std::vector<Wire>> inputs;  // connected ones only
  std::vector<Place> through;                       // where the subgraphs around it are used, innermost first
  bool in_subgraph() const { return path.find('/') != std::string::npos; }
};

struct GraphOutput {
  std::string name;
  Wire wire;
};

// A parameter that a graph offers to its user.
struct GraphParameter {
  Parameter declaration;
  Place place;
};

struct Graph {
  std::string name;
  std::string doc;
  std::string file;
  std::vector<GraphNode> nodes;  // sources before their consumers
  std::vector<GraphOutput> outputs;
  std::vector<Port> inputs;  // what a graph around this one may connect
  std::vector<GraphParameter> parameters;

  int find(const std::string& path) const;  // −1 where there is none
  std::vector<std::string> paths() const;
  // Wire to "node.port", or "node" where the node has one output. Throws Error "unknown-node" /
  // "unknown-port".
  Wire wire_to(const std::string& text) const;
  // Nodes that are evaluated when nobody names a target: what nobody consumes (in subgraphs only what writes
  // files), and the graph's own outputs.
  std::vector<int> sinks() const;
};

// What is changed without touching the file: "asset/pack.seed" = "2", "photo" = "x.png".
struct Overrides {
  std::vector<std::pair<std::string, std::string>> set;
  std::vector<std::pair<std::string, std::string>> parameters;
  // Input "asset/pack.shapes" ← outputs {"shape.shapes"}, in the place of what the file connects; none
  // disconnects.
  std::vector<std::pair<std::string, std::vector<std::string>>> wires = {};
};

// Reads a graph file and checks everything: every mistake ends up in `found`, with its place. The result can
// be run only if has_errors(found) is false. Paths in values are made absolute against the file that they
// stand in, those in overrides against the working folder.
Graph load_graph(const std::filesystem::path& file, const Registry&, const Overrides&, Diagnostics& found);

// The same from text, as if it stood in `file` (which need not exist).
Graph load_graph_text(const std::string& text, const std::filesystem::path& file, const Registry&,
                      const Overrides&, Diagnostics& found);

}  // namespace terrazzo
