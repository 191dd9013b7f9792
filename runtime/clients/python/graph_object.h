// The C++ side of terrazzo.Graph: a document that is edited, and a session that evaluates it.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>

#include "runtime/clients/python/bind.h"
#include "runtime/given.h"
#include "runtime/session.h"

namespace terrazzo::python {

// Whether this process was forked from one that evaluated. It has no worker threads.
bool process_was_forked();

class GraphObject {
 public:
  // `script`: the file that builds the graph. Evaluations must not overwrite it, and the history of its nodes
  // is kept under its name.
  GraphObject(SessionOptions options, const std::string& script) : options_(std::move(options)) {
    document_.file = std::filesystem::absolute(script.empty() ? "python" : script).lexically_normal();
  }
  ~GraphObject();  // stops running evaluations

  void open(const std::filesystem::path&);
  void open_text(const std::string& text, const std::filesystem::path& file);

  // --- edits. They throw Error and change nothing if they are wrong by themselves. Rules across nodes are
  // checked by link().
  struct Edit {
    // Parameters and inputs by name, and "each". None: back to the default.
    std::map<std::string, py::object> values;
    Place place;  // in the user's script
  };
  std::string add(const std::string& type, std::string name, const Edit&);
  std::string add_subgraph(const std::filesystem::path& file, std::string name, const Edit&);
  void set(const std::string& node, const Edit&);
  void remove(const std::string& node);
  void rename(const std::string& node, const std::string& name);
  void add_parameter(RawParameter);
  void set_parameter(const std::string& name, const py::object& value, const Place&);
  // An output or input of the graph. Without a reference, removes it.
  void set_port(bool output, const std::string& name, const std::string& reference, const Place&);
  void set_name(const std::string& name, const std::string& doc);

  const RawDocument& document() const { return document_; }
  const std::filesystem::path& opened() const { return opened_; }
  const NodeType& type_of(const std::string& node);  // throws Error "unknown-node"
  // A parameter of a node as it is set, as a Python object; None if it is not set.
  py::object parameter(const std::string& node, const std::string& name);

  // The same as it is written, to be set again later.
  py::object written_parameter(const std::string& node, const std::string& name);

  // Links the document, unless nothing changed since. Raises the errors; returns warnings and notes.
  const Diagnostics& link();
  Session& session();
  // The targets as the session knows them; links the document.
  std::vector<std::string> targets(const std::vector<std::string>& given);
  std::uint64_t revision() const { return revision_; }

  // The value of a node "GivenImage" and so on.
  Value given_value(const std::string& node) const;
  // What stands in a file for a node that holds a value: a node that reads or makes the value.
  struct StandIn {
    std::string type, output;
    std::map<std::string, py::object> params;
  };
  using StandIns = std::map<std::string, StandIn>;
  // The document as YAML, with paths relative to this folder. Throws Error "not-savable", unless there is a
  // stand-in for every node that holds a value.
  std::string text(const std::filesystem::path& folder, const StandIns& = {}) const;
  // The same without subgraphs, repetitions and parameters: every node that would be evaluated.
  std::string flat_text(const std::filesystem::path& folder, const StandIns& = {}) const;
  // Throws Error "overwrites-input" if this file is one that the graph reads or a subgraph. Its own file may
  // be written again.
  void require_other_file(const std::filesystem::path&) const;

  // What a node is repeated for, by name: the values as written. Empty for other nodes.
  std::vector<std::pair<std::string, WrittenValue>> each(const std::string& node);
  // Whether "NODE.PORT", or this output of the graph, is a list: the node has `each`.
  bool is_list(const std::string& output) const;

  // The value of an output if it was evaluated before and nothing changed since, input files included. An
  // empty Value otherwise, or if the store has dropped it.
  Value known(const std::string& output);
  void remember(const std::string& output, std::uint64_t revision, const Graph&, const RunResult&,
                const Wire&);

  // Evaluations keep the values that they need, so that the graph may change meanwhile.
  const std::map<std::string, std::shared_ptr<const GivenValue>>& given() const { return given_; }

 private:
  const RawNode* find(const std::string& node) const;
  // Also finds the repeated node that has an element of this name, "solid[17]".
  const RawNode* find_written(const std::string& node) const;
  void apply(RawNode&, const NodeType&, const Edit&);
  RawDocument savable(const StandIns&, Overrides&) const;
  void apply_inside(const std::string& node, const NodeType&, const Edit&);
  std::vector<RawReference> wires(const std::string& node, const Port&, const py::object&, const Place&);
  std::string output_of(const py::handle&, const Port&, const std::string& node);
  std::string give(const Value&, const std::string& like, const Place&);
  std::string free_name(const std::string& like) const;
  const NodeType& subgraph_type(const std::filesystem::path&);
  void changed() { ++revision_; }

  SessionOptions options_;
  std::unique_ptr<Session> session_;
  RawDocument document_;
  std::string original_;                 // the text that was opened
  std::filesystem::path opened_;         // its file, or ""
  Overrides overrides_;                  // of nodes in subgraphs
  std::set<std::string> inner_outputs_;  // outputs of subgraphs that were evaluated: "asset.particles"
  std::uint64_t revision_ = 1, linked_ = 0;
  Diagnostics found_;
  std::unordered_map<std::string, std::size_t> index_;
  std::map<std::string, std::shared_ptr<NodeType>> subgraph_types_;
  std::map<std::string, std::shared_ptr<const GivenValue>> given_;

  struct Known {
    std::uint64_t revision = 0;
    std::shared_ptr<const Graph> graph;
    OutputRecord record;
    std::vector<std::pair<int, std::vector<FileRecord>>> reads;  // nodes that read files
  };
  std::map<std::string, Known> known_;
  void reindex();
  void drop_unused_values();
};

// An output of a node, which can be connected to inputs and evaluated.
struct OutputObject {
  py::object graph;  // keeps it alive
  std::string node, port, type;
  std::string text() const { return node + "." + port; }
};

struct NodeObject {
  py::object graph;
  std::string name;
};

// "${photo}": a parameter of the graph as the value of a node's parameter.
struct ParameterReference {
  py::object graph;
  std::string name;
};

}  // namespace terrazzo::python
