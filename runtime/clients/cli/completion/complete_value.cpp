#include "runtime/clients/cli/completion/complete_value.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>

#include "runtime/clients/cli/completion/complete_file.h"
#include "runtime/clients/cli/graph_names.h"
#include "runtime/clients/cli/help/declared.h"
#include "runtime/clients/cli/placeholders.h"

namespace terrazzo::cli {
namespace {

using Words = std::vector<std::string>;

// Reads the names under a time limit, because a hostile graph may take minutes or contain a pipe. Then there
// are no candidates.
GraphNames names_in_time(const std::string& graph) {
  std::signal(SIGALRM, [](int) { ::_exit(0); });
  ::alarm(1);
  GraphNames names = read_graph_names(graph);
  ::alarm(0);
  return names;
}

const NodeType* type_of_node(const Program& program, const NamedNode& node) {
  if (node.type.empty()) return nullptr;
  const NodeType* type = program.registry().find(node.type);
  return type ? type : program.registry().find_former(node.type);
}

// Whether a name of this node, such as "NODE.PARAM", may begin with `typed`.
bool may_complete(const NamedNode& node, const std::string& typed) {
  const std::string head = node.path + ".";
  return head.starts_with(typed) || typed.starts_with(head);
}

Words values_of(const Parameter& p, const std::string& typed) {
  if (p.kind == ParameterKind::InputPath || p.kind == ParameterKind::OutputPath)
    return complete_file(typed, FileKind::any);
  Words out = p.choices;
  if (p.kind == ParameterKind::Bool) out = {"true", "false"};
  out.insert(out.end(), p.keywords.begin(), p.keywords.end());
  return out;
}

// Completes "NAME=" or, if there is a '=', the value after it. `list`: after the last comma of that value.
void complete_setting(const std::vector<Parameter>& parameters, const std::string& node, bool list,
                      const std::string& typed, Words& out) {
  for (const Parameter& p : parameters) {
    std::string head = node + p.name + "=";
    if (!typed.starts_with(head)) {
      out.push_back(head);
      continue;
    }
    if (const auto comma = typed.rfind(','); list && comma != std::string::npos && comma >= head.size())
      head = typed.substr(0, comma + 1);
    for (const auto& value : values_of(p, typed.substr(head.size()))) out.push_back(head + value);
  }
}

void complete_node_settings(const Program& program, const GraphNames& names, bool list,
                            const std::string& typed, Words& out) {
  for (const NamedNode& node : names.nodes) {
    if (!may_complete(node, typed)) continue;
    const NodeType* type = type_of_node(program, node);
    complete_setting(type ? type->parameters : node.parameters, node.path + ".", list, typed, out);
  }
}

void complete_ports(const Program& program, const GraphNames& names, const std::string& typed, Words& out) {
  for (const NamedNode& node : names.nodes)
    if (may_complete(node, typed))
      if (const NodeType* type = type_of_node(program, node))
        for (const Port& port : type->outputs) out.push_back(node.path + "." + port.name);
}

void complete_node_types(const Program& program, const std::string& typed, Words& out) {
  if (typed.find_first_of("./") == std::string::npos) out = program.registry().names();
  // Files only if no type fits, because the working folder is seldom what the user is looking for.
  if (std::none_of(out.begin(), out.end(), [&](const auto& name) { return name.starts_with(typed); }))
    out = complete_file(typed, FileKind::graph);
}

}  // namespace

Words complete_value(const Program& program, const CLI::Option& option, const std::string& graph,
                     const std::string& typed) {
  if (Words choices = choices_of(option); !choices.empty()) return choices;
  const std::string what = placeholder_of(option);
  const bool nodes = what == placeholder::node_setting, parameters = what == placeholder::graph_setting,
             both = what == placeholder::varied_setting, target = what == placeholder::target,
             output = what == placeholder::output;
  Words out;
  if (nodes || parameters || both || target || output) {
    const GraphNames names = names_in_time(graph);
    if (parameters || both) complete_setting(names.parameters, "", both, typed, out);
    if (nodes || both) complete_node_settings(program, names, both, typed, out);
    if (target || output) out = names.outputs;
    if (output || (target && typed.find('.') != std::string::npos))
      complete_ports(program, names, typed, out);
    else if (target)
      for (const NamedNode& node : names.nodes)
        if (!node.type.empty() && !std::count(names.outputs.begin(), names.outputs.end(), node.path))
          out.push_back(node.path);
    return out;
  }
  if (what == placeholder::number || what == placeholder::bytes) return {};
  if (what == placeholder::graph) return complete_file(typed, FileKind::graph);
  if (what == placeholder::folder) return complete_file(typed, FileKind::folder);
  if (what == placeholder::node_type) {
    complete_node_types(program, typed, out);
    return out;
  }
  return complete_file(typed, FileKind::any);
}

}  // namespace terrazzo::cli
