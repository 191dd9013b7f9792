#include "graph/document/edit_document.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/document/patch_yaml.h"
#include "graph/document/write_document.h"
#include "graph/document/yaml_text.h"
#include "graph/text/element_name.h"
#include "graph/text/nearest.h"

namespace terrazzo {
namespace {

using Kind = Edit::Kind;

template <class List>
auto find_name(List& list, const std::string& name) {
  return std::find_if(list.begin(), list.end(), [&](const auto& entry) { return entry.first == name; });
}

RawNode* find_node(RawDocument& doc, const std::string& name) {
  const auto it =
      std::find_if(doc.nodes.begin(), doc.nodes.end(), [&](const RawNode& n) { return n.name == name; });
  return it == doc.nodes.end() ? nullptr : &*it;
}

// Whether "pack.particles", "pack" or "pack[3].particles" names an output of the node.
bool refers_to(const RawReference& r, const std::string& node) {
  return r.text == node || (r.text.size() > node.size() && r.text.compare(0, node.size(), node) == 0 &&
                            (r.text[node.size()] == '.' || r.text[node.size()] == '['));
}

// Changes text and document in step.
class Editor {
 public:
  Editor(const ReadGraph& graph, const std::filesystem::path& file)
      : text_(graph.text), file_(file), doc_(graph.document) {
    if (has_errors(graph.found))
      throw Error("cannot-edit", "the file has errors: " + graph.found.front().message,
                  "correct the text first; only then can its nodes be edited");
  }

  ReadGraph apply(const Edit& e) {
    switch (e.kind) {
      case Kind::SetParameter:
        set(node(e.node).params, {"nodes", e.node, "params", e.name}, e.name,
            RawValue{{e.value.is_list, e.value.items, {}}, {}}, yaml_value(e.value));
        break;
      case Kind::ResetParameter:
        remove(node(e.node).params, {"nodes", e.node, "params", e.name}, e.name);
        break;
      case Kind::AppendItem:
        append(e);
        break;
      case Kind::RemoveItem:
        remove_item(e);
        break;
      case Kind::SetDefault:
        set_default(e);
        break;
      case Kind::SetSubgraph:
        take(set_yaml_entry(text_, {"nodes", e.node, "graph"}, yaml_word(e.graph)));
        node(e.node).graph = e.graph;
        break;
      case Kind::SetBypass:
        if (node(e.node).bypass == e.bypass) break;
        take(e.bypass ? set_yaml_entry(text_, {"nodes", e.node, "bypass"}, "true")
                      : remove_yaml_entry(text_, {"nodes", e.node, "bypass"}));
        node(e.node).bypass = e.bypass;
        break;
      case Kind::Connect:
        connect(e.node, e.name, e.wires);
        break;
      case Kind::Rewire:
        rewire([&](const std::string& wire) { return wire == e.name ? e.to : wire; }, e.node);
        break;
      case Kind::AddNode:
        add(e);
        break;
      case Kind::RemoveNode:
        remove_node(e.node);
        break;
      case Kind::RenameNode:
        rename_node(e.node, e.to);
        break;
    }
    return checked();
  }

 private:
  RawNode& node(const std::string& name) {
    if (RawNode* found = find_node(doc_, name)) return *found;
    std::vector<std::string> names;
    for (const auto& n : doc_.nodes) names.push_back(n.name);
    throw Error("unknown-node", fmt::format("there is no node '{}'{}", name, did_you_mean(name, names)));
  }

  void take(std::optional<std::string> text) {
    if (!text)
      throw Error("cannot-edit", "the file says this in a way that cannot be changed here",
                  "edit the text of the file");
    text_ = std::move(*text);
  }

  // Sets an entry of `params` or `inputs` in the document and in the text.
  template <class List, class Value>
  void set(List& list, const YamlPath& path, const std::string& name, Value value, const std::string& yaml) {
    take(set_yaml_entry(text_, path, yaml));
    const auto it = find_name(list, name);
    if (it == list.end())
      list.push_back({name, std::move(value)});
    else
      it->second = std::move(value);
  }

  // Removes an entry, and the mapping around it with its last entry.
  template <class List>
  void remove(List& list, YamlPath path, const std::string& name) {
    const auto it = find_name(list, name);
    if (it == list.end()) return;
    if (list.size() == 1) path.pop_back();
    take(remove_yaml_entry(text_, path));
    list.erase(it);
  }

  void append(const Edit& e) {
    auto& params = node(e.node).params;
    const YamlPath path{"nodes", e.node, "params", e.name};
    const std::string item = yaml_word(e.value.text());
    const auto it = find_name(params, e.name);
    if (it != params.end() && it->second.written.is_list && !it->second.written.items.empty()) {
      take(append_yaml_item(text_, path, item));
      it->second.written.items.push_back(e.value.text());
      return;
    }
    const WrittenValue list{true, {e.value.text()}, {}};
    if (!params.empty()) return set(params, path, e.name, RawValue{list, {}}, yaml_list(list.items));
    take(add_yaml_block(text_, {"nodes", e.node, "params"}, yaml_word(e.name) + ":\n  - " + item,
                        "{" + yaml_word(e.name) + ": " + yaml_list(list.items) + "}"));
    params.push_back({e.name, RawValue{list, {}}});
  }

  void remove_item(const Edit& e) {
    auto& params = node(e.node).params;
    const YamlPath path{"nodes", e.node, "params", e.name};
    const auto it = find_name(params, e.name);
    if (it == params.end() || e.index >= it->second.written.items.size())
      throw Error("unknown-item", fmt::format("{}.{} has no item {}", e.node, e.name, e.index + 1));
    auto& items = it->second.written.items;
    if (items.size() == 1) return remove(params, path, e.name);
    take(remove_yaml_item(text_, path, e.index));
    items.erase(items.begin() + e.index);
  }

  void set_default(const Edit& e) {
    const auto it = std::find_if(doc_.parameters.begin(), doc_.parameters.end(),
                                 [&](const RawParameter& p) { return p.declaration.name == e.name; });
    if (it == doc_.parameters.end())
      throw Error("unknown-parameter", fmt::format("the graph has no parameter '{}'", e.name));
    take(set_yaml_entry(text_, {"parameters", e.name, "default"}, yaml_value(e.value)));
    it->value.written = {e.value.is_list, e.value.items, {}};
  }

  void connect(const std::string& name, const std::string& input, const std::vector<std::string>& wires) {
    const YamlPath path{"nodes", name, "inputs", input};
    RawNode& n = node(name);
    if (wires.empty()) return remove(n.inputs, path, input);
    std::vector<RawReference> references;
    for (const auto& w : wires) references.push_back({w, {}});
    set(n.inputs, path, input, std::move(references),
        wires.size() == 1 ? yaml_word(wires[0]) : yaml_list(wires));
  }

  void check_new_name(const std::string& name) {
    if (name.empty() || name.find_first_of(". /") != std::string::npos)
      throw Error("bad-name", fmt::format("'{}' is not a valid name for a node", name),
                  "use a word without dots, slashes and spaces");
    if (find_node(doc_, name)) throw Error("name-taken", fmt::format("there is already a node '{}'", name));
  }

  void add(const Edit& e) {
    check_new_name(e.node);
    const std::string line = e.graph.empty() ? "type: " + yaml_word(e.type) : "graph: " + yaml_word(e.graph);
    take(add_yaml_block(text_, {"nodes", e.node}, line, "{" + line + "}"));
    RawNode n;
    n.name = e.node;
    n.type = e.type;
    n.graph = e.graph;
    doc_.nodes.push_back(std::move(n));
  }

  void remove_node(const std::string& name) {
    node(name);
    for (auto& n : doc_.nodes) {
      if (n.name == name) continue;
      for (auto inputs = n.inputs; const auto& [input, wires] : inputs) {
        std::vector<std::string> kept;
        for (const auto& w : wires)
          if (!refers_to(w, name)) kept.push_back(w.text);
        if (kept.size() < wires.size()) connect(n.name, input, kept);
      }
    }
    for (auto outputs = doc_.outputs; const auto& [output, reference] : outputs)
      if (refers_to(reference, name)) remove(doc_.outputs, {"outputs", output}, output);
    if (doc_.nodes.size() == 1)
      take(set_yaml_entry(text_, {"nodes"}, "{}"));
    else
      take(remove_yaml_entry(text_, {"nodes", name}));
    std::erase_if(doc_.nodes, [&](const RawNode& n) { return n.name == name; });
  }

  // Changes every wire and every output and input of the graph to `now(wire)`, except wires to a node.
  template <class Now>
  void rewire(Now&& now, const std::string& except = {}) {
    for (auto& n : doc_.nodes) {
      if (n.name == except) continue;
      for (auto inputs = n.inputs; const auto& [input, wires] : inputs) {
        std::vector<std::string> texts;
        for (const auto& w : wires) texts.push_back(now(w.text));
        if (!std::ranges::equal(wires, texts, {}, &RawReference::text)) connect(n.name, input, texts);
      }
    }
    for (auto& [key, list] : {std::pair{"outputs", &doc_.outputs}, std::pair{"inputs", &doc_.inputs}})
      for (auto& [port, reference] : *list) {
        const std::string text = now(reference.text);
        if (text == reference.text) continue;
        reference.text = text;
        take(set_yaml_entry(text_, {key, port}, yaml_word(text)));
      }
  }

  void rename_node(const std::string& name, const std::string& to) {
    node(name);
    check_new_name(to);
    rewire([&](const std::string& wire) {
      return refers_to({wire, {}}, name) ? to + wire.substr(name.size()) : wire;
    });
    take(rename_yaml_entry(text_, {"nodes", name}, to));
    node(name).name = to;
  }

  // YAML has many ways to write a document. So the patched text counts only if it reads back as intended.
  ReadGraph checked() {
    ReadGraph again = read_graph(std::move(text_), file_);
    if (has_errors(again.found) || !same_document(again.document, doc_))
      throw Error("cannot-edit",
                  "the file says this in a way that cannot be changed without changing something else",
                  "edit the text of the file");
    return again;
  }

  std::string text_;
  std::filesystem::path file_;
  RawDocument doc_;
};

}  // namespace

ReadGraph read_graph(std::string text, const std::filesystem::path& file) {
  ReadGraph out;
  out.document = read_document(text, file, out.found);
  out.text = std::move(text);
  return out;
}

std::string edit_document(const std::string& text, const std::filesystem::path& file, const Edit& edit) {
  return edit_document(read_graph(text, file), file, edit).text;
}

ReadGraph edit_document(const ReadGraph& graph, const std::filesystem::path& file, const Edit& edit) {
  return Editor(graph, file).apply(edit);
}

}  // namespace terrazzo
