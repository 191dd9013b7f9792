// Graph: a document with all subgraphs expanded and all names resolved. This is what the evaluator runs.
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

struct RawDocument;  // graph/document/raw_document.h

struct Wire {
  int node = -1;  // index of the source node
  std::string port;
  Place place;
};

struct SetParameter {
  ParameterValue value;
  Place place;  // where it was set; the line is 0 for the command line
  std::string as_written;
  std::vector<Place> items = {};  // of a list that was read from a file: the place of each item
};

struct GraphNode {
  std::string path;  // "asset/pack"
  const NodeType* type = nullptr;
  Place place;
  std::map<std::string, SetParameter> parameters;   // only those that are set
  std::map<std::string, std::vector<Wire>> inputs;  // only those that are connected
  std::vector<Place> through;                       // where the enclosing subgraphs are used, innermost first
  // Path of the node or innermost enclosing subgraph that has `may_fail`; "" if there is none.
  std::string may_fail;
  bool in_subgraph() const { return path.find('/') != std::string::npos; }
};

struct GraphOutput {
  std::string name;
  Wire wire;
};

// A parameter declared by the graph itself.
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
  std::vector<Port> inputs;  // inputs that an enclosing graph may connect
  std::vector<GraphParameter> parameters;
  // Bypassed nodes are not in `nodes`. By path: for each output, what its readers read instead. An output
  // that no input of the node can take the place of is missing.
  std::map<std::string, std::map<std::string, Wire>> bypassed;

  int find(const std::string& path) const;  // −1 if there is no such node
  std::vector<std::string> paths() const;
  // Wire to a graph output, to "node.port", or to "node" if that node has exactly one output. For a bypassed
  // node, to what its readers read. Throws Error "unknown-node", "unknown-port" or "cannot-bypass".
  Wire wire_to(const std::string& text) const;
  // The default targets: nodes that write files, nodes outside subgraphs whose outputs nobody uses, and the
  // nodes of the graph's outputs.
  std::vector<int> sinks() const;
};

// Changes applied to a graph without editing its file: "asset/pack.seed" = "2", "photo" = "x.png".
struct Overrides {
  std::vector<std::pair<std::string, std::string>> set;
  std::vector<std::pair<std::string, std::string>> parameters;
  // Input "asset/pack.shapes" ← outputs {"shape.shapes"}. Replaces the wires in the file; an empty list
  // disconnects the input.
  std::vector<std::pair<std::string, std::vector<std::string>>> wires = {};
  // Texts of subgraphs in place of what their files contain, by the file as its users' folder and `graph`
  // name it.
  std::map<std::filesystem::path, std::string> files = {};
};

// Reads and checks a graph file. Appends every error to `found`, with its place. Run the result only if
// has_errors(found) is false. Relative paths in a file are resolved against that file's folder, paths in
// overrides against the working folder.
Graph load_graph(const std::filesystem::path& file, const Registry&, const Overrides&, Diagnostics& found);

// Like load_graph(), but for text that is treated as the content of `file`, which does not need to exist.
Graph load_graph_text(const std::string& text, const std::filesystem::path& file, const Registry&,
                      const Overrides&, Diagnostics& found);

// Like load_graph(), but for a document that was made or changed in memory. A relative path in a value is
// resolved against the folder of the file in the value's place.
Graph link_document(RawDocument doc, const Registry&, const Overrides&, Diagnostics& found);

}  // namespace terrazzo
