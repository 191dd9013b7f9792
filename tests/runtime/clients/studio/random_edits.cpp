#include "tests/runtime/clients/studio/random_edits.h"

#include <algorithm>

namespace terrazzo::test {
namespace {
using Kind = Edit::Kind;

template <class List>
auto entry_named(List& list, const std::string& name) {
  return std::ranges::find_if(list, [&](const auto& e) { return e.first == name; });
}

}  // namespace

bool names(const std::string& wire, const std::string& node) {
  return wire == node || wire.starts_with(node + ".") || wire.starts_with(node + "[");
}

RawDocument intended(RawDocument doc, const Edit& e) {
  const auto node = std::ranges::find(doc.nodes, e.node, &RawNode::name);
  const auto rewire = [&](auto&& now) {
    for (auto& n : doc.nodes)
      for (auto& [port, list] : n.inputs)
        for (auto& w : list)
          if (e.kind != Kind::Rewire || n.name != e.node) w.text = now(w.text);
    for (auto* list : {&doc.outputs, &doc.inputs})
      for (auto& [port, w] : *list) w.text = now(w.text);
  };
  const auto put = [&](auto& list, auto value) {
    if (const auto it = entry_named(list, e.name); it != list.end())
      it->second = value;
    else
      list.push_back({e.name, value});
  };
  switch (e.kind) {
    case Kind::SetParameter:
      put(node->params, RawValue{e.value, {}});
      break;
    case Kind::ResetParameter:
      std::erase_if(node->params, [&](const auto& p) { return p.first == e.name; });
      break;
    case Kind::AppendItem:
    case Kind::RemoveItem: {
      RawValue v{{true, {}, {}}, {}};
      if (const auto it = entry_named(node->params, e.name);
          it != node->params.end() && it->second.written.is_list)
        v = it->second;
      auto& items = v.written.items;
      if (e.kind == Kind::AppendItem)
        items.push_back(e.value.items[0]);
      else
        items.erase(items.begin() + static_cast<std::ptrdiff_t>(e.index));
      if (items.empty())
        std::erase_if(node->params, [&](const auto& p) { return p.first == e.name; });
      else
        put(node->params, v);
      break;
    }
    case Kind::SetDefault:
      for (auto& p : doc.parameters)
        if (p.declaration.name == e.name) p.value.written = e.value;
      break;
    case Kind::SetSubgraph:
      node->graph = e.graph;
      break;
    case Kind::SetBypass:
      node->bypass = e.bypass;
      break;
    case Kind::Connect: {
      std::vector<RawReference> list;
      for (const auto& w : e.wires) list.push_back({w, {}});
      if (list.empty())
        std::erase_if(node->inputs, [&](const auto& i) { return i.first == e.name; });
      else
        put(node->inputs, list);
      break;
    }
    case Kind::Rewire:
      rewire([&](const std::string& w) { return w == e.name ? e.to : w; });
      break;
    case Kind::AddNode:
      doc.nodes.emplace_back();
      doc.nodes.back().name = e.node, doc.nodes.back().type = e.type, doc.nodes.back().graph = e.graph;
      break;
    case Kind::RenameNode:
      node->name = e.to;
      rewire([&](const std::string& w) { return names(w, e.node) ? e.to + w.substr(e.node.size()) : w; });
      break;
    case Kind::RemoveNode:
      doc.nodes.erase(node);
      for (auto& n : doc.nodes) {
        for (auto& [port, list] : n.inputs)
          std::erase_if(list, [&](const auto& w) { return names(w.text, e.node); });
        std::erase_if(n.inputs, [](const auto& i) { return i.second.empty(); });
      }
      std::erase_if(doc.outputs, [&](const auto& o) { return names(o.second.text, e.node); });
  }
  return doc;
}

Edit RandomEdits::next(const RawDocument& doc, std::size_t number) {
  const auto each = std::ranges::find_if(doc.nodes, [](const RawNode& n) { return !n.each.empty(); });
  const RawNode& node = each != doc.nodes.end() && below(4) == 0 ? *each : pick(doc.nodes);  // few have it
  Edit e;
  e.kind = static_cast<Kind>(below(static_cast<std::size_t>(Kind::RenameNode) + 1));
  e.node = node.name;
  const std::string stem = below(4) ? "fresh" : "größe", fresh = stem + "_" + std::to_string(number);
  e.name = stem;  // of a parameter or an input that is perhaps not set
  switch (e.kind) {
    case Kind::SetParameter:
      if (!node.params.empty() && below(4)) e.name = pick(node.params).first;
      e.value = value();
      break;
    case Kind::ResetParameter:
      if (node.params.empty()) return next(doc, number);
      e.name = pick(node.params).first;
      break;
    case Kind::AppendItem:
      if (!node.params.empty() && below(2)) e.name = pick(node.params).first;
      e.value = {false, {word()}, {}};
      break;
    case Kind::RemoveItem: {
      if (node.params.empty()) return next(doc, number);
      const auto& [list, written] = pick(node.params);
      if (!written.written.is_list || written.written.items.empty()) return next(doc, number);
      e.name = list;
      e.index = below(written.written.items.size());
      break;
    }
    case Kind::SetDefault:
      if (doc.parameters.empty()) return next(doc, number);
      e.name = pick(doc.parameters).declaration.name;
      e.value = value();
      break;
    case Kind::SetSubgraph:
      if (node.graph.empty()) return next(doc, number);
      e.graph = "../" + word() + ".yaml";
      break;
    case Kind::SetBypass:
      e.bypass = !node.bypass;
      break;
    case Kind::Connect:
      if (!node.inputs.empty() && below(4)) e.name = pick(node.inputs).first;
      for (std::size_t k = below(4); k-- > 0;) e.wires.push_back(wire(doc));
      if (e.wires.empty() && entry_named(node.inputs, e.name) == node.inputs.end()) return next(doc, number);
      break;
    case Kind::Rewire:
      if (node.inputs.empty()) return next(doc, number);
      e.name = pick(pick(node.inputs).second).text;
      e.to = wire(doc);
      e.node = below(2) ? pick(doc.nodes).name : "";
      break;
    case Kind::AddNode:
      e.node = fresh;
      (below(4) ? e.type : e.graph) = "Section";
      break;
    case Kind::RemoveNode:
      if (doc.nodes.size() < 3 || (!node.each.empty() && below(8))) return next(doc, number);
      break;
    case Kind::RenameNode:
      e.to = "renamed_" + std::to_string(number);
  }
  return e;
}

std::string RandomEdits::word() {
  static const std::vector<std::string> words = {
      "1",      "-1.5e3", "a b",  "",      "${x}", "true",  "null", "~",          "# no comment",
      "a: b",   "[x]",    "{y}",  "é日",   "it's", "\"q\"", "@at",  "two\nlines", " edge ",
      "- dash", "0x1F",   "1, 2", "*star", "&and", "!tag",  "%",    "a #b",       "tab\t",
      "\\",     "?",      "|"};
  return pick(words);
}
WrittenValue RandomEdits::value() {
  if (below(3)) return {false, {word()}, {}};
  WrittenValue list{true, {}, {}};
  for (std::size_t k = 1 + below(3); k-- > 0;) list.items.push_back(word());
  return list;
}

}  // namespace terrazzo::test
