// Nodes with `each`: one node per combination of values takes the place of the node.
#include <fmt/format.h>

#include <algorithm>

#include "graph/linker.h"
#include "graph/text/element_name.h"
#include "graph/value_range.h"

namespace terrazzo {
namespace {

// All combinations of the values, the last name fastest.
template <class Use>
void each_element(const std::vector<Variable>& variables, std::size_t count, Use&& use) {
  std::vector<std::size_t> at(variables.size());
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t rest = i;
    for (std::size_t k = variables.size(); k-- > 0;) {
      at[k] = rest % variables[k].values.size();
      rest /= variables[k].values.size();
    }
    use(at);
  }
}

}  // namespace

std::vector<Given> Linker::read_values(const Scope& scope, const RawNode& raw, const std::string& name,
                                       const RawValue& value) {
  const std::string path = scope.prefix + raw.name;
  const auto wrong = [&](std::string code, const std::string& why, Place at, std::string hint = {}) {
    too_large_ = too_large_ || code == "too-large";
    fail(std::move(code), fmt::format("the values of '{}'{}", name, why), std::move(at), std::move(hint),
         path);
    return std::vector<Given>();
  };
  Given all = substitute(scope, value);
  if (all.written.items.empty() && !all.written.is_list) return {};  // substitute() reported the error
  if (!all.written.is_list) {
    try {
      if (auto range = read_range(all.written.text(), kMaxExpandedNodes))
        all.written.items = std::move(*range);
    } catch (const Error& e) {
      return wrong(e.diagnostic().code, ": " + e.diagnostic().message, all.place, "write LO:HI:STEP");
    }
  }
  if (all.written.items.empty()) return wrong("bad-value", " are an empty list", all.place);
  if (all.written.items.size() > kMaxExpandedNodes)
    return wrong("too-large", fmt::format(" are more than {}", kMaxExpandedNodes), all.place);
  std::vector<Given> out;
  std::set<std::string> seen;
  for (std::size_t k = 0; k < all.written.items.size(); ++k) {
    Given one{{false, {all.written.items[k]}, {}}, all.folder, all.place};
    if (k < all.written.places.size()) std::tie(one.place.line, one.place.column) = all.written.places[k];
    if (!seen.insert(one.written.items[0]).second)
      return wrong("duplicate-key", fmt::format(" contain '{}' twice", one.written.items[0]), one.place);
    out.push_back(std::move(one));
  }
  return out;
}

void Linker::refuse_repeated(const std::string& path, std::string code, std::string message, Place at,
                             std::string hint) {
  too_large_ = too_large_ || code == "too-large";
  fail(std::move(code), std::move(message), std::move(at), std::move(hint), path);
  unknown_.insert(path);
}

std::vector<Variable> Linker::read_variables(const Scope& scope, const RawNode& raw, std::uint64_t& count) {
  const std::string path = scope.prefix + raw.name;
  std::vector<Variable> variables;
  count = 1;
  for (const auto& [name, value] : raw.each) {
    if (!is_variable_name(name))
      refuse_repeated(path, "bad-name", fmt::format("'{}' is not a valid name for values", name), value.place,
                      "use letters, digits and _");
    else if (scope.parameters.count(name))
      refuse_repeated(path, "duplicate-key", fmt::format("'{}' is also a parameter of the graph", name),
                      value.place, "choose another name");
    variables.push_back({name, read_values(scope, raw, name, value)});
    count *= variables.back().values.size();
    if (count == 0) unknown_.insert(path);
    if (count > kMaxExpandedNodes) {
      refuse_repeated(path, "too-large",
                      fmt::format("'{}' has more than {} elements", raw.name, kMaxExpandedNodes),
                      value.place);
      break;
    }
  }
  if (unknown_.count(path)) return {};
  return variables;
}

bool Linker::take_repeated(const Scope& scope, const RawNode& raw, std::uint64_t count) {
  const std::string path = scope.prefix + raw.name;
  // files_ counted the node once.
  const Expansion one = files_->expansion(scope.doc, raw);
  expanded_ += (count - 1) * one.nodes;
  bytes_ += (count - 1) * one.bytes;
  const Place& place = raw.each.front().second.place;
  if (expanded_ > kMaxExpandedNodes) {
    refuse_repeated(
        path, "too-large",
        fmt::format("the graph expands to {} nodes, {} of them in the {} elements of '{}'; the limit is {}",
                    expanded_, count * one.nodes, count, raw.name, kMaxExpandedNodes),
        place, "use fewer values, or split the graph into several");
    return false;
  }
  if (bytes_ > kMaxExpandedBytes) {
    refuse_repeated(path, "too-large", too_much_text(bytes_), place, "use fewer values, or shorter lists");
    return false;
  }
  return true;
}

RawNode Linker::make_element(Scope& scope, const RawNode& raw, const std::vector<Variable>& variables,
                             const std::vector<std::size_t>& at) {
  const std::string path = scope.prefix + raw.name;
  std::vector<ElementValue> values;
  Element element{raw.name, {}};
  for (std::size_t k = 0; k < variables.size(); ++k) {
    const Given& value = variables[k].values[at[k]];
    values.push_back({value.written.items[0], at[k]});
    element.values[variables[k].name] = value;
  }
  RawNode node = raw;
  node.each.clear();
  node.name = element_name(raw.name, values);
  for (auto& [port, refs] : node.inputs)
    for (auto& ref : refs) {
      auto text = substitute_values(element, ref);
      if (!text) unknown_.insert(path);
      ref.text = std::move(text).value_or("");
    }
  if (scope.nodes.count(node.name))
    fail("duplicate-key",
         fmt::format("there is a node '{}' besides the elements of '{}'", node.name, raw.name),
         scope.nodes.at(node.name)->place, {}, path);
  scope.elements.emplace(node.name, std::move(element));
  return node;
}

void Linker::repeat_nodes(Scope& scope) {
  auto& nodes = scope.doc.nodes;
  if (std::none_of(nodes.begin(), nodes.end(), [](const RawNode& n) { return !n.each.empty(); })) return;
  std::vector<RawNode> out;
  for (const RawNode& raw : nodes) {
    if (too_large_) break;
    if (raw.each.empty()) {
      out.push_back(raw);  // a copy, because scope.nodes points to the original
      continue;
    }
    std::uint64_t count = 0;
    const std::vector<Variable> variables = read_variables(scope, raw, count);
    if (variables.empty()) continue;
    if (!take_repeated(scope, raw, count)) break;
    std::vector<RawNode> elements;
    each_element(variables, count, [&](const std::vector<std::size_t>& at) {
      elements.push_back(make_element(scope, raw, variables, at));
    });
    if (unknown_.count(scope.prefix + raw.name)) continue;
    auto& names = scope.lists[raw.name];
    for (RawNode& node : elements) {
      names.push_back(node.name);
      out.push_back(std::move(node));
    }
  }
  nodes = std::move(out);
}

std::optional<std::string> Linker::substitute_values(const Element& element, const RawReference& ref) {
  std::string out;
  std::size_t at = 0;
  while (true) {
    const auto open = ref.text.find("${", at);
    const auto close = open == std::string::npos ? open : ref.text.find('}', open);
    if (close == std::string::npos) return out + ref.text.substr(at);
    const std::string name = ref.text.substr(open + 2, close - open - 2);
    const auto value = element.values.find(name);
    if (value == element.values.end()) {
      std::vector<std::string> names;
      for (const auto& [known, v] : element.values) names.push_back(known);
      fail("unknown-parameter", fmt::format("'{}' has no values '{}'", element.of, name), ref.place,
           fmt::format("wires may contain {}", fmt::join(names, ", ")));
      return {};
    }
    out += ref.text.substr(at, open - at) + value->second.written.items[0];
    at = close + 1;
  }
}

void Linker::drop_repeated_messages() {
  constexpr int kMost = 5;  // messages of one kind about the elements of one node
  struct Kind {
    int count = 0;
    std::size_t last = 0;  // message kept
  };
  using Key = std::tuple<std::string, int, int, std::string, std::string>;
  std::map<Key, Kind> kinds;
  std::set<std::pair<Key, std::string>> seen;
  Diagnostics kept;
  for (auto& d : found_) {
    const std::string node = without_elements(d.node);
    const Key key{d.place.file, d.place.line, d.place.column, d.code, node};
    if (!seen.insert({key, d.message}).second) continue;
    Kind& kind = kinds[key];
    if (node != d.node && ++kind.count > kMost) continue;
    kind.last = kept.size();
    kept.push_back(std::move(d));
  }
  for (const auto& [key, kind] : kinds)
    if (kind.count > kMost) {
      std::string& hint = kept[kind.last].hint;
      hint +=
          fmt::format("{}{} more elements have such an error", hint.empty() ? "" : "; ", kind.count - kMost);
    }
  found_ = std::move(kept);
}

}  // namespace terrazzo
