// Linker: from documents to a Graph. Opens subgraphs, fills in parameters, resolves wires, checks everything
// it meets.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <unordered_map>

#include "graph/graph.h"
#include "graph/raw_document.h"
#include "graph/subgraph_files.h"

namespace terrazzo {

// A written value with the folder that relative paths in it mean, and where it came from.
struct Given {
  WrittenValue written;
  std::filesystem::path folder;
  Place place;
};

// One opened file: the graph itself, or a subgraph under the path of its node.
struct Scope {
  std::string prefix;  // "" or "asset/"
  RawDocument doc;
  Scope* parent = nullptr;
  const RawNode* node = nullptr;                          // in the parent
  std::unordered_map<std::string, const RawNode*> nodes;  // of the document, by name
  std::map<std::string, Given> parameters;
};

class Linker {
 public:
  Linker(const Registry& registry, const Overrides& overrides, Diagnostics& found)
      : registry_(registry),
        overrides_(overrides),
        found_(found),
        used_(overrides.set.size(), false),
        used_wires_(overrides.wires.size(), false) {}

  Graph link(RawDocument doc);

 private:
  void fail(std::string code, std::string message, Place at, std::string hint = {}, std::string node = {},
            std::string parameter = {});
  void note(std::string code, std::string message, Place at, std::string node);
  // Where the subgraphs around a scope are used, innermost first.
  static std::vector<Place> uses(const Scope&);
  void add_uses_to_messages();

  Given from_command_line(const std::string& text, const std::string& what);

  int find(const std::string& path) const;

  // --- parameters

  // Replaces ${name}. A value that is nothing but one reference keeps the type and origin of what it names.
  Given substitute(const Scope& scope, const RawValue& raw);

  void fill_parameters(Scope& scope, std::map<std::string, Given> given);

  void set_parameter(GraphNode& node, const std::string& name, const Given& given);
  // The parameter that once had this name, said so in a note; or null.
  const Parameter* find_former(const GraphNode&, const std::string& name, const Place&);

  // --- scopes

  // Refuses a graph that would grow too large. What it counts is the same as what would be built.
  bool check_size(const RawDocument& root);

  Scope& open(RawDocument doc, std::string prefix, Scope* parent, const RawNode* node,
              std::map<std::string, Given> given);

  void add_node(Scope& scope, const RawNode& raw);

  void add_subgraph(Scope& scope, const RawNode& raw);

  void apply_set();

  // --- wires

  // Replaces what the file connects by what the overrides say.
  void override_wires(Scope&);
  void report_unused_wires();

  // Follows a reference through subgraphs to the node that makes the value. Mistakes are reported once, where
  // written.
  std::optional<Wire> resolve(Scope& scope, const RawReference& ref, int depth = 0);

  void connect(Scope& scope, const RawNode& raw);

  void attach(Scope& scope, int index, const Port& port, const RawReference& ref);

  void check_subgraph_inputs(Scope& scope, const RawNode& raw);

  void check_wiring_of_ports();
  // The graph's own inputs with the types of the ports they stand for; what names nothing is a mistake.
  void describe_inputs(Scope& root);

  // Sources before consumers, otherwise in the order written.
  void sort();
  // `way`: nodes that each consume the next; the last consumes `node`, which is one of them.
  void report_cycle(const std::vector<int>& way, int node);

  const Registry& registry_;
  const Overrides& overrides_;
  Diagnostics& found_;
  std::vector<bool> used_, used_wires_;  // of the overrides
  Graph graph_;
  std::optional<SubgraphFiles> files_;
  std::map<std::string, std::unique_ptr<Scope>> scopes_;
  std::map<std::string, int> index_;  // of graph_.nodes by path
  std::set<std::string> unknown_;     // paths whose type or file is unknown, already reported
  std::set<std::pair<int, std::string>> broken_inputs_;
  std::set<std::pair<std::string, std::string>> attempted_;  // parameters written, rightly or not
};

}  // namespace terrazzo
