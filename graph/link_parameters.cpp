// Linking parameters: references, defaults, overrides, former names.
#include <fmt/format.h>

#include <algorithm>

#include "graph/linker.h"
#include "graph/node_parameters.h"
#include "graph/output_path.h"
#include "graph/text/element_name.h"
#include "graph/text/nearest.h"

namespace terrazzo {
namespace fs = std::filesystem;

Given Linker::from_command_line(const std::string& text, const std::string& what) {
  Given g{{false, {text}}, fs::current_path(), {"command line (" + what + ")", 0, 0}};
  try {
    g.written = read_written(text);
  } catch (const Error& e) {
    fail("bad-value", e.diagnostic().message, g.place, e.diagnostic().hint);
  }
  return g;
}

Given Linker::substitute(const Scope& scope, const RawValue& raw, const RawNode* of) {
  const auto element = of ? scope.elements.find(of->name) : scope.elements.end();
  const auto value_of = [&](const std::string& name) -> const Given* {
    if (element != scope.elements.end())
      if (const auto it = element->second.values.find(name); it != element->second.values.end())
        return &it->second;
    const auto it = scope.parameters.find(name);
    return it == scope.parameters.end() ? nullptr : &it->second;
  };
  Given out{raw.written, fs::path(raw.place.file).parent_path(), raw.place};
  for (auto& item : out.written.items) {
    std::string text;
    std::size_t at = 0;
    while (true) {
      const auto open = item.find("${", at);
      const auto close = open == std::string::npos ? open : item.find('}', open);
      if (close == std::string::npos) break;
      const std::string name = item.substr(open + 2, close - open - 2);
      const Given* value = value_of(name);
      if (!value) {
        std::vector<std::string> names;
        for (const auto& p : scope.doc.parameters) names.push_back(p.declaration.name);
        if (std::find(names.begin(), names.end(), name) == names.end())
          fail("unknown-parameter",
               fmt::format("the graph has no parameter '{}'{}", name, did_you_mean(name, names)), raw.place);
        return out.written.items.clear(), out;
      }
      if (!raw.written.is_list && open == 0 && close + 1 == item.size()) {
        Given whole = *value;
        if (value->place.line <= 0 && value->place.file.empty()) whole.place = raw.place;
        return whole;
      }
      text += item.substr(at, open - at) + value->written.text();
      at = close + 1;
    }
    item = text + item.substr(at);
  }
  return out;
}

void Linker::fill_parameters(Scope& scope, std::map<std::string, Given> given) {
  std::vector<std::string> names;
  for (const auto& p : scope.doc.parameters) {
    const std::string& name = p.declaration.name;
    names.push_back(name);
    Given value;
    if (const auto it = given.find(name); it != given.end()) {
      value = std::move(it->second);
      given.erase(it);
    } else if (!p.value.written.items.empty() || p.value.written.is_list) {
      value = {p.value.written, scope.doc.file.parent_path(), p.value.place};
    } else {
      fail("missing-parameter", fmt::format("parameter '{}' has no default and must be set", name),
           scope.node ? scope.node->place : p.place);
      continue;
    }
    std::string why;
    if (!read_parameter(p.declaration, value.written, why)) {
      fail("bad-value", why, value.place, {},
           scope.prefix.empty() ? "" : scope.prefix.substr(0, scope.prefix.size() - 1), name);
      continue;
    }
    scope.parameters[name] = std::move(value);
  }
  for (const auto& [name, value] : given)
    fail("unknown-parameter",
         fmt::format("{} has no parameter '{}'{}", scope.node ? "'" + scope.node->graph + "'" : "the graph",
                     name, did_you_mean(name, names)),
         value.place);
}

const Parameter* Linker::find_former(const GraphNode& node, const std::string& name, const Place& at) {
  for (const auto& p : node.type->parameters)
    if (std::find(p.former_names.begin(), p.former_names.end(), name) != p.former_names.end()) {
      note("former-name", fmt::format("'{}' of {} is now called '{}'", name, node.type->name, p.name), at,
           node.path);
      return &p;
    }
  return nullptr;
}

WrittenValue Linker::rename_former_words(const GraphNode& node, const Parameter& p, const Given& given) {
  WrittenValue out = given.written;
  for (std::string& item : out.items)
    for (const auto& [former, word] : p.former_words)
      if (item == former) {
        note("former-name", fmt::format("{}: '{}' is now called '{}'", p.name, former, word), given.place,
             node.path);
        item = word;
        break;
      }
  return out;
}

void Linker::check_output_paths() {
  struct Writer {
    const GraphNode* node;
    std::string path;
  };
  std::map<std::string, Writer> writers;  // by normal path
  for (const GraphNode& node : graph_.nodes)
    for (const Parameter& p : node.type->parameters) {
      const auto given = node.parameters.find(p.name);
      if (p.kind != ParameterKind::OutputPath || given == node.parameters.end()) continue;
      if (bypassed_.count(node.path)) continue;
      const auto& path = std::get<std::string>(given->second.value);
      if (is_reserved_output(path))
        fail("reserved-name", fmt::format("'{}' is the name of a file that terrazzo itself writes", path),
             given->second.place, "choose another file name, or a folder below the output folder", node.path,
             p.name);
      const std::string normal = fs::path(path).lexically_normal().generic_string();
      const auto [it, first] = writers.emplace(without_case(normal), Writer{&node, normal});
      if (first) continue;
      const auto& [other, written] = it->second;
      fail("same-file",
           written == normal
               ? fmt::format("'{}' and '{}' both write '{}'", other->path, node.path, path)
               : fmt::format("'{}' and '{}' write '{}' and '{}', which are one file where upper "
                             "and lower case are the same",
                             other->path, node.path, written, normal),
           given->second.place, "give each its own file name", node.path, p.name);
    }
}

void Linker::check_parameters() {
  for (const GraphNode& node : graph_.nodes) {
    if (!node.type->check || bypassed_.count(node.path)) continue;
    std::map<std::string, ParameterValue> set;
    bool complete = true;
    for (const Parameter& p : node.type->parameters) {
      const auto given = node.parameters.find(p.name);
      if (given != node.parameters.end())
        set.emplace(p.name, given->second.value);
      else if (!p.value || attempted_.count({node.path, p.name}))
        complete = false;  // missing or wrong, which is reported elsewhere
    }
    if (!complete) continue;
    try {
      node.type->check(NodeParameters(*node.type, std::move(set)));
    } catch (const Error& e) {
      Diagnostic d = e.diagnostic();
      const auto at = node.parameters.find(d.parameter);
      Place place = node.place;
      if (at != node.parameters.end()) {
        const auto& items = at->second.items;
        place = d.item >= 0 && d.item < static_cast<int>(items.size()) ? items[d.item] : at->second.place;
      }
      fail(d.code, d.message, place, d.hint, node.path, d.parameter);
    }
  }
}

void Linker::set_parameter(GraphNode& node, const std::string& name, const Given& given) {
  const Parameter* p = node.type->find_parameter(name);
  if (!p) p = find_former(node, name, given.place);
  attempted_.insert({node.path, p ? p->name : name});
  if (!p) {
    std::vector<std::string> names;
    for (const auto& q : node.type->parameters) names.push_back(q.name);
    return fail("unknown-parameter",
                fmt::format("{} has no parameter '{}'{}", node.type->name, name, did_you_mean(name, names)),
                given.place, {}, node.path);
  }
  if (given.written.items.empty() && !given.written.is_list) return;  // substitute() reported the error
  std::string why;
  auto value = read_parameter(*p, rename_former_words(node, *p, given), why);
  if (!value) return fail("bad-value", why, given.place, {}, node.path, p->name);
  if (p->kind == ParameterKind::InputPath) {
    // A keyword names no file. Everything that lists a graph's files skips parameters that are not set.
    if (const auto& words = p->keywords;
        std::find(words.begin(), words.end(), std::get<std::string>(*value)) != words.end()) {
      node.parameters.erase(p->name);
      return;
    }
    fs::path path = std::get<std::string>(*value);
    if (path.is_relative()) path = given.folder / path;
    value = fs::absolute(path).lexically_normal().string();
  }
  std::vector<Place> items;
  for (const auto& [line, column] : given.written.places) items.push_back({given.place.file, line, column});
  node.parameters[p->name] = {std::move(*value), given.place, given.written.text(), std::move(items)};
}

void Linker::apply_set() {
  for (std::size_t i = 0; i < overrides_.set.size(); ++i) {
    if (used_[i]) continue;
    const auto& [target, value] = overrides_.set[i];
    const Given given = from_command_line(value, "--set " + target);
    const auto dot = find_port_dot(target);
    const std::string name = target.substr(0, dot);
    bool found = false;
    for (GraphNode& node : graph_.nodes)
      if (dot != std::string::npos && is_named(node.path, name)) {
        found = true;
        set_parameter(node, target.substr(dot + 1), given);
      }
    const auto stands_for = [&](const std::string& path) { return is_named(path, name); };
    if (!found && std::none_of(unknown_.begin(), unknown_.end(), stands_for))
      fail("unknown-node", fmt::format("there is no node '{}'{}", name, did_you_mean(name, graph_.paths())),
           given.place, dot == std::string::npos ? "write NODE.PARAM=VALUE" : "");
  }
}

}  // namespace terrazzo
