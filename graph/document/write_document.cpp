#include "graph/document/write_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "graph/document/yaml_text.h"
#include "graph/text/read_number.h"

namespace terrazzo {
namespace {

constexpr std::size_t kWidth = 158;  // of a line, in bytes

// A number with every digit, without an exponent if it is moderate.
std::string number(double v) {
  std::string text = fmt::format("{}", v);
  if (text.find('e') == std::string::npos || std::abs(v) < 1e-9 || std::abs(v) > 1e15) return text;
  for (int digits = 0; digits < 20; ++digits)
    if (std::string fixed = fmt::format("{:.{}f}", v, digits); read_number(fixed) == v) return fixed;
  return text;
}

using Entries = std::vector<std::pair<std::string, std::string>>;  // key and written value

// "key: {a: 1, b: 2}" on one line if it is short, otherwise a line for each entry.
std::string map_text(const std::string& indent, const std::string& key, const Entries& entries) {
  std::string one;
  for (const auto& [k, v] : entries) one += (one.empty() ? "" : ", ") + yaml_word(k) + ": " + v;
  one = indent + key + ": {" + one + "}\n";
  if (one.size() <= kWidth) return one;
  std::string out = indent + key + ":\n";
  for (const auto& [k, v] : entries) out += indent + "  " + yaml_word(k) + ": " + v + "\n";
  return out;
}

std::string text_of(const RawNode& node) {
  std::string out = "  " + yaml_word(node.name) + ":\n";
  out += node.graph.empty() ? "    type: " + yaml_word(node.type) + "\n"
                            : "    graph: " + yaml_word(node.graph) + "\n";
  if (!node.doc.empty()) out += "    doc: " + yaml_word(node.doc) + "\n";
  if (node.bypass) out += "    bypass: true\n";
  if (node.may_fail) out += "    may_fail: true\n";
  Entries each, inputs, params;
  for (const auto& [name, v] : node.each) each.emplace_back(name, yaml_value(v.written));
  if (!each.empty()) out += map_text("    ", "each", each);
  for (const auto& [port, wires] : node.inputs) {
    std::vector<std::string> list;
    for (const auto& w : wires) list.push_back(w.text);
    inputs.emplace_back(port, list.size() == 1 ? yaml_word(list[0]) : yaml_list(list));
  }
  for (const auto& [name, v] : node.params) params.emplace_back(name, yaml_value(v.written));
  if (!inputs.empty()) out += map_text("    ", "inputs", inputs);
  if (!params.empty()) out += map_text("    ", "params", params);
  return out;
}

std::string text_of(const RawParameter& p) {
  const Parameter& d = p.declaration;
  Entries e{{"type", name_of(d.kind)}};
  if (!p.value.written.items.empty() || p.value.written.is_list)
    e.emplace_back("default", yaml_value(p.value.written));
  if (!d.keywords.empty()) e.emplace_back("keywords", yaml_list(d.keywords));
  if (std::isfinite(d.min)) e.emplace_back("min", number(d.min));
  if (std::isfinite(d.max)) e.emplace_back("max", number(d.max));
  if (!d.choices.empty()) e.emplace_back("choices", yaml_list(d.choices));
  if (!d.doc.empty()) e.emplace_back("doc", yaml_word(d.doc));
  if (!d.unit.empty()) e.emplace_back("unit", yaml_word(d.unit));
  std::string one;
  for (const auto& [k, v] : e) one += (one.empty() ? "" : ", ") + k + ": " + v;
  return "  " + yaml_word(d.name) + ": {" + one + "}\n";  // on one line whatever its length, as in graphs/
}

using RawPort = std::pair<std::string, RawReference>;  // of `inputs` and `outputs`

std::string text_of(const RawPort& p) {
  return "  " + yaml_word(p.first) + ": " + yaml_word(p.second.text) + "\n";
}

const std::string& name(const RawNode& n) { return n.name; }
const std::string& name(const RawParameter& p) { return p.declaration.name; }
const std::string& name(const RawPort& p) { return p.first; }
int line(const RawNode& n) { return n.place.line; }
int line(const RawParameter& p) { return p.place.line; }
int line(const RawPort& p) { return p.second.place.line; }

bool same(const WrittenValue& a, const WrittenValue& b) {
  return a.is_list == b.is_list && a.items == b.items;
}

bool same(const RawNode& a, const RawNode& b) {
  const auto param = [](const auto& x, const auto& y) {
    return x.first == y.first && same(x.second.written, y.second.written);
  };
  const auto wire = [](const RawReference& x, const RawReference& y) { return x.text == y.text; };
  const auto input = [&](const auto& x, const auto& y) {
    return x.first == y.first && std::ranges::equal(x.second, y.second, wire);
  };
  return a.name == b.name && a.type == b.type && a.graph == b.graph && a.doc == b.doc &&
         a.bypass == b.bypass && a.may_fail == b.may_fail && std::ranges::equal(a.each, b.each, param) &&
         std::ranges::equal(a.params, b.params, param) && std::ranges::equal(a.inputs, b.inputs, input);
}

bool same(const RawParameter& a, const RawParameter& b) {
  const Parameter &x = a.declaration, &y = b.declaration;
  return x.name == y.name && x.kind == y.kind && x.doc == y.doc && x.unit == y.unit && x.min == y.min &&
         x.max == y.max && x.choices == y.choices && x.keywords == y.keywords &&
         same(a.value.written, b.value.written);
}

bool same(const RawPort& a, const RawPort& b) { return a.first == b.first && a.second.text == b.second.text; }

template <class Item>
bool same_list(const std::vector<Item>& a, const std::vector<Item>& b) {
  return std::ranges::equal(a, b, [](const Item& x, const Item& y) { return same(x, y); });
}

template <class Item>
std::string section_text(const std::string& key, const std::vector<Item>& items) {
  if (items.empty()) return key == "nodes" ? "nodes: {}\n" : "";
  std::string out = key + ":\n";
  for (const auto& item : items) out += text_of(item);
  return out;
}

constexpr std::array kKeys = {"terrazzo", "name", "doc", "parameters", "nodes", "inputs", "outputs"};

// The text of one top-level key as it is written anew. "" if the key is not needed.
std::string fresh_section(const RawDocument& doc, const std::string& key) {
  if (key == "terrazzo") return fmt::format("terrazzo: {}\n", kGraphFormat);
  if (key == "name") return doc.name.empty() ? "" : "name: " + yaml_word(doc.name) + "\n";
  if (key == "doc") return doc.doc.empty() ? "" : "doc: " + yaml_word(doc.doc) + "\n";
  if (key == "parameters") return section_text(key, doc.parameters);
  if (key == "nodes") return section_text(key, doc.nodes);
  return section_text(key, key == "inputs" ? doc.inputs : doc.outputs);
}

std::string fresh_text(const RawDocument& doc) {
  std::string out;
  for (const char* key : kKeys) out += fresh_section(doc, key);
  return out;
}

// Text by line, with line breaks.
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size() - 1) + 1;
    out.push_back(text.substr(at, end - at));
    if (out.back().back() != '\n') out.back() += '\n';
    at = end;
  }
  return out;
}

bool is_comment(const std::string& line) {
  const auto at = line.find_first_not_of(" \t");
  return at == std::string::npos || line[at] == '#' || line[at] == '\n';
}

// The original text, cut into top-level keys and their entries.
class Original {
 public:
  explicit Original(const std::string& text) : lines_(lines_of(text)) {
    Diagnostics found;
    doc_ = read_document(text, "original", found);
    valid_ = !has_errors(found);
    for (std::size_t i = 0; i < lines_.size() && valid_; ++i)
      for (const char* key : kKeys)
        if (lines_[i].rfind(std::string(key) + ":", 0) == 0) {
          valid_ = valid_ && !starts_.count(key);
          starts_[key] = i;
          order_.push_back(key);
        }
    valid_ = valid_ && starts_.count("terrazzo") && starts_.count("nodes");
  }

  std::string with(const RawDocument& doc) const {
    if (!valid_) return {};
    std::vector<std::string> order = order_;
    for (std::size_t k = 1; k < kKeys.size(); ++k) {  // keys that the original lacks, behind the one before
      if (starts_.count(kKeys[k])) continue;
      const auto before = std::find(order.begin(), order.end(), kKeys[k - 1]);
      order.insert(before == order.end() ? before : before + 1, kKeys[k]);
    }
    std::string out;
    for (const auto& key : order) {
      if (!starts_.count(key)) {
        out += fresh_section(doc, key);
        continue;
      }
      if (key == "terrazzo")
        out += rest(key);
      else if (key == "name")
        out += doc.name == doc_.name ? rest(key) : lead(key) + fresh_section(doc, key);
      else if (key == "doc")
        out += doc.doc == doc_.doc ? rest(key) : lead(key) + fresh_section(doc, key);
      else if (key == "parameters")
        out += section(key, doc_.parameters, doc.parameters);
      else if (key == "nodes")
        out += section(key, doc_.nodes, doc.nodes);
      else
        out +=
            key == "inputs" ? section(key, doc_.inputs, doc.inputs) : section(key, doc_.outputs, doc.outputs);
    }
    return out;
  }

 private:
  std::string join(std::size_t from, std::size_t to) const {
    std::string out;
    for (std::size_t i = from; i < to; ++i) out += lines_[i];
    return out;
  }
  // The first line of the comment above a line, but not before `from`.
  std::size_t comment_above(std::size_t at, std::size_t from) const {
    while (at > from && is_comment(lines_[at - 1])) --at;
    return at;
  }
  std::size_t first(const std::string& key) const { return comment_above(starts_.at(key), 0); }
  std::size_t end(const std::string& key) const {
    const auto at = std::find(order_.begin(), order_.end(), key) + 1;
    return at == order_.end() ? lines_.size() : first(*at);
  }
  std::string lead(const std::string& key) const { return join(first(key), starts_.at(key)); }
  std::string rest(const std::string& key) const { return join(first(key), end(key)); }

  template <class Item>
  std::string section(const std::string& key, const std::vector<Item>& before,
                      const std::vector<Item>& now) const {
    if (same_list(before, now)) return rest(key);
    if (now.empty() && key != "nodes") return {};
    // Each entry must start on a line of its own, below the line of the key.
    const std::size_t start = starts_.at(key), stop = end(key);
    std::vector<std::size_t> at;
    for (const auto& item : before) {
      const std::size_t number = line(item) - 1;
      if (number <= (at.empty() ? start : at.back()) || number >= stop)
        return lead(key) + section_text(key, now);
      at.push_back(number);
    }
    if (before.empty() || now.empty()) return lead(key) + section_text(key, now);
    std::map<std::string, std::size_t> index;
    for (std::size_t k = 0; k < before.size(); ++k) index[name(before[k])] = k;
    std::string out = join(first(key), start + 1);
    for (const auto& item : now) {
      const auto known = index.find(name(item));
      if (known == index.end()) {
        out += text_of(item);
        continue;
      }
      const std::size_t k = known->second;
      const std::size_t top = comment_above(at[k], k == 0 ? start + 1 : at[k - 1] + 1);
      const std::size_t bottom = k + 1 < at.size() ? comment_above(at[k + 1], at[k] + 1) : stop;
      out += same(item, before[k]) ? join(top, bottom) : join(top, at[k]) + text_of(item);
    }
    return out;
  }

  std::vector<std::string> lines_;
  RawDocument doc_;
  bool valid_ = false;
  std::map<std::string, std::size_t> starts_;  // line of each top-level key
  std::vector<std::string> order_;             // the keys in the order of the text
};

}  // namespace

bool same_document(const RawDocument& a, const RawDocument& b) {
  return a.name == b.name && a.doc == b.doc && same_list(a.parameters, b.parameters) &&
         same_list(a.nodes, b.nodes) && same_list(a.inputs, b.inputs) && same_list(a.outputs, b.outputs);
}

std::string write_document(const RawDocument& doc, const std::string& original) {
  if (original.empty()) return fresh_text(doc);
  // YAML has many ways to write a document, such as a map in braces over several lines. So the patched text
  // counts only if it reads back as the document.
  const std::string patched = Original(original).with(doc);
  Diagnostics found;
  const RawDocument again = read_document(patched, doc.file, found);
  return !has_errors(found) && same_document(again, doc) ? patched : fresh_text(doc);
}

}  // namespace terrazzo
