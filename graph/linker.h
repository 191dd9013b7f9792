// Linker: turns documents into a Graph. It opens subgraphs, fills in parameters, resolves wires and checks
// all of it.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <unordered_map>

#include "graph/document/raw_document.h"
#include "graph/document/subgraph_files.h"
#include "graph/graph.h"

namespace terrazzo {

// A written value, the base folder of relative paths in it, and the place it came from.
struct Given {
  WrittenValue written;
  std::filesystem::path folder;
  Place place;
};

// An element of a repeated node: the name of that node, and this element's values.
struct Element {
  std::string of;
  std::map<std::string, Given> values;
};

// One opened file: the root graph, or a subgraph at the path of its node.
struct Scope {
  std::string prefix;  // "" or "asset/"
  RawDocument doc;
  Scope* parent = nullptr;
  const RawNode* node = nullptr;                          // in the parent
  std::string may_fail;                                   // as GraphNode's
  std::unordered_map<std::string, const RawNode*> nodes;  // nodes of the document by name
  std::map<std::string, Given> parameters;
  std::unordered_map<std::string, std::vector<std::string>> lists;  // elements of repeated nodes, in order
  std::unordered_map<std::string, Element> elements;                // by name: "solid[17]"
  std::vector<std::string> names;                                   // of the nodes, as the file has them

  // The name in the file of a node of `doc`.
  const std::string& written_name(const RawNode& raw) const {
    const auto it = elements.find(raw.name);
    return it == elements.end() ? raw.name : it->second.of;
  }
};

// One name of `each` with its values.
struct Variable {
  std::string name;
  std::vector<Given> values;
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
  // Where a scope and its enclosing subgraphs are used, innermost first.
  static std::vector<Place> uses(const Scope&);
  void add_uses_to_messages();
  static std::string too_much_text(std::uint64_t bytes);

  Given from_command_line(const std::string& text, const std::string& what);

  int find(const std::string& path) const;
  const NodeType* type_of(const RawNode&) const;  // by its present or former name; null if unknown

  // --- parameters

  // Replaces ${name}, of the graph's parameters and of the values of the element `of`. A value that consists
  // of one reference keeps the list or scalar, folder and place of the parameter it names.
  Given substitute(const Scope& scope, const RawValue& raw, const RawNode* of = nullptr);

  void fill_parameters(Scope& scope, std::map<std::string, Given> given);

  void set_parameter(GraphNode& node, const std::string& name, const Given& given);
  // The parameter that had this name in an earlier version, or null. Reports the new name in a note.
  const Parameter* find_former(const GraphNode&, const std::string& name, const Place&);
  // Replaces former words of choices and keywords, with a note.
  WrittenValue rename_former_words(const GraphNode&, const Parameter&, const Given&);
  // Runs the checks of node types across parameters, on nodes whose parameters are all valid.
  void check_parameters();
  // Rejects two nodes that would write the same file below the output folder.
  void check_output_paths();

  // --- repeated nodes

  // Replaces nodes with `each` by their elements, with the values filled into their wires.
  void repeat_nodes(Scope&);
  // The values of one name of `each`. Reports what is wrong with them and returns none.
  std::vector<Given> read_values(const Scope&, const RawNode&, const std::string& name, const RawValue&);
  // All names of `each`, and the number of their combinations. Empty if they cannot be used.
  std::vector<Variable> read_variables(const Scope&, const RawNode&, std::uint64_t& count);
  // Counts the elements of a repeated node. False if the graph gets too large.
  bool take_repeated(const Scope&, const RawNode&, std::uint64_t count);
  // The element with value at[k] of variable k.
  RawNode make_element(Scope&, const RawNode&, const std::vector<Variable>&,
                       const std::vector<std::size_t>& at);
  // Reports what is wrong with a repeated node, which then counts as unknown.
  void refuse_repeated(const std::string& path, std::string code, std::string message, Place at,
                       std::string hint = {});
  std::optional<std::string> substitute_values(const Element&, const RawReference&);
  // Keeps one of equal messages about elements of a node, and only the first few that differ.
  void drop_repeated_messages();

  // --- scopes

  // Rejects a graph that would expand to too many nodes. Counts exactly the nodes that would be built,
  // without repeated ones, which depend on values.
  bool check_size(const RawDocument& root);

  Scope& open(RawDocument doc, std::string prefix, Scope* parent, const RawNode* node,
              std::map<std::string, Given> given);

  // Replaces former names of ports by present ones, in this file's wires, inputs and outputs.
  void rename_former_ports(Scope&);
  void rename_former_port(const Scope&, RawReference&, bool also_inputs);

  void add_node(Scope& scope, const RawNode& raw);

  void add_subgraph(Scope& scope, const RawNode& raw);

  void apply_set();

  // --- wires

  // Replaces wires in the file with those in the overrides.
  void override_wires(Scope&);
  void report_unused_wires();

  // Follows a reference through subgraphs to the nodes that produce the values: one, or several if it leads
  // to a repeated node. Reports each error once, at the reference, and then returns none.
  std::vector<Wire> resolve(Scope& scope, const RawReference& ref, int depth = 0);
  void report_unknown_node(const Scope&, const std::string& name, const Place&);
  // `of`: the node or graph, which has the outputs `names`.
  void report_unknown_output(const std::string& of, const std::string& port,
                             const std::vector<std::string>& names, const Place&);

  void connect(Scope& scope, const RawNode& raw);

  void attach(Scope& scope, int index, const Port& port, const RawReference& ref);
  // Counts the elements of lists that wires lead through. Like take_wires().
  bool take_elements(std::size_t, const RawReference&);
  // Counts wires. Reports once that there are too many; false from then on.
  bool take_wires(std::size_t, const RawReference&);
  // Adds an output of the graph: one value, or several that are named "output[#0]", "output[#1]", …
  void add_output(const std::string& name, const std::vector<Wire>&);

  void check_subgraph_inputs(Scope& scope, const RawNode& raw);

  void check_wiring_of_ports();
  // Connects all nodes and outputs, and sorts the graph.
  void connect_all(Scope& root);
  // Adds the graph's inputs with the types of the ports that they name. Reports names that do not exist.
  void describe_inputs(Scope& root);

  // Puts sources before consumers and otherwise keeps the order of the file. False if there is a cycle.
  bool sort();
  // Leaves bypassed nodes out of the sorted graph, and connects their readers to what they pass through.
  void remove_bypassed();
  // `way`: nodes that each consume the next one. The last consumes `node`, which is also in `way`.
  void report_cycle(const std::vector<int>& way, int node);

  const Registry& registry_;
  const Overrides& overrides_;
  Diagnostics& found_;
  // The graph is too large, so nothing more is expanded or connected.
  bool too_large_ = false;
  std::uint64_t expanded_ = 0;           // nodes after expansion, as far as scopes are open
  std::uint64_t bytes_ = 0;              // of these nodes as text
  std::size_t wires_ = 0;                // connected so far
  std::size_t elements_ = 0;             // of lists, followed so far
  std::vector<bool> used_, used_wires_;  // per override: was it applied?
  Graph graph_;
  std::optional<SubgraphFiles> files_;
  std::map<std::string, std::unique_ptr<Scope>> scopes_;
  std::map<std::string, int> index_;  // indices into graph_.nodes by path
  std::set<std::string> bypassed_;    // paths
  std::set<std::string> unknown_;     // paths whose type or file is unknown, already reported
  std::set<std::pair<int, std::string>> broken_inputs_;      // inputs with a wire, valid or not
  std::set<std::pair<std::string, std::string>> attempted_;  // parameters with a value, valid or not
};

}  // namespace terrazzo
