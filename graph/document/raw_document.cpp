#include "graph/document/raw_document.h"

#include <fmt/format.h>
#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <string_view>

#include "graph/document/yaml_mistakes.h"
#include "graph/text/element_name.h"
#include "graph/text/nearest.h"
#include "graph/text/read_number.h"
#include "graph/text/utf8.h"

namespace terrazzo {
namespace {

class DocumentReader {
 public:
  DocumentReader(std::filesystem::path file, Diagnostics& found) : found_(found) {
    doc_.file = std::move(file);
  }

  RawDocument read(const std::string& text) {
    text_ = text;
    if (const auto bad = find_invalid_utf8(text); bad != std::string::npos) {
      fail("not-utf8", fmt::format("the byte 0x{:02x} is not UTF-8", static_cast<unsigned char>(text[bad])),
           place(text, bad), "save the file as UTF-8");
      return std::move(doc_);
    }
    if (separators(text) > kMaxGraphValues) {
      fail_too_large({doc_.file.string(), 1, 1});
      return std::move(doc_);
    }
    YAML::Node root;
    try {
      root = YAML::Load(text);
    } catch (const YAML::Exception& e) {
      fail_to_parse(e);
      return std::move(doc_);
    }
    if (!root.IsMap()) {
      fail("not-a-graph", "a graph file is a map with the keys terrazzo, name, nodes",
           {doc_.file.string(), 1, 1});
      return std::move(doc_);
    }
    bool has_version = false, has_nodes = false;
    each_key(root, {"terrazzo", "name", "doc", "parameters", "nodes", "inputs", "outputs"}, "a graph file",
             [&](const std::string& key, const YAML::Node& k, const YAML::Node& v) {
               if (key == "terrazzo") {
                 has_version = true;
                 read_version(v, k);
               } else if (key == "name" && v.IsScalar()) {
                 doc_.name = v.Scalar();
               } else if (key == "doc" && v.IsScalar()) {
                 doc_.doc = v.Scalar();
               } else if (key == "parameters") {
                 each_key(v, {}, "parameters",
                          [&](const auto& n, const auto& nk, const auto& nv) { read_parameter_(n, nk, nv); });
               } else if (key == "nodes") {
                 has_nodes = true;
                 each_key(v, {}, "nodes",
                          [&](const auto& n, const auto& nk, const auto& nv) { read_node(n, nk, nv); });
               } else if (key == "inputs" || key == "outputs") {
                 auto& list = key == "inputs" ? doc_.inputs : doc_.outputs;
                 each_key(v, {}, key, [&](const auto& n, const auto&, const auto& nv) {
                   if (nv.IsScalar())
                     list.push_back({n, {nv.Scalar(), place(nv.Mark())}});
                   else
                     fail("bad-reference", fmt::format("'{}' must be NODE.PORT", n), place(nv.Mark()));
                 });
               }
             });
    if (!has_version)
      fail("no-version", "the format version is missing", {doc_.file.string(), 1, 1},
           fmt::format("start the file with 'terrazzo: {}'", kGraphFormat));
    if (!has_nodes) fail("no-nodes", "the graph has no nodes", {doc_.file.string(), 1, 1});
    return std::move(doc_);
  }

 private:
  Place place(const YAML::Mark& m) const { return {doc_.file.string(), m.line + 1, m.column + 1}; }
  Place place(const std::string& text, std::size_t at) const {
    const auto begin = text.begin(), end = begin + at;
    const auto line = std::find(std::make_reverse_iterator(end), text.rend(), '\n').base();
    const auto starts = [](char c) { return (c & 0xc0) != 0x80; };  // the first byte of a character
    return {doc_.file.string(), 1 + static_cast<int>(std::count(begin, end, '\n')),
            1 + static_cast<int>(std::count_if(line, end, starts))};
  }
  void fail(std::string code, std::string message, Place at, std::string hint = {}) {
    found_.push_back(
        {Severity::Error, std::move(code), std::move(message), std::move(hint), std::move(at), {}, {}});
  }

  void fail_to_parse(const YAML::Exception& e) {
    const Place at = place(e.mark);
    if (const auto* deep = dynamic_cast<const YAML::DeepRecursion*>(&e))
      fail("yaml", fmt::format("values are nested more than {} deep", deep->depth()), at);
    else if (const auto mistake = yaml_mistake(text_, std::max(1, at.line)))
      fail("yaml", mistake->message, place(text_, mistake->at), mistake->hint);
    else
      fail("yaml", e.msg, at);
  }

  // Every value except the first follows a separator, so this bounds the number of nodes that the parser
  // builds.
  static std::size_t separators(const std::string& text) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char c = text[i], next = i + 1 < text.size() ? text[i + 1] : '\n';
      n += c == ',' || c == ':' || c == '\n' || c == '[' || c == '{' ||
           ((c == '-' || c == '?') && next == ' ');
    }
    return n;
  }

  void fail_too_large(Place at) {
    fail("too-large",
         fmt::format("the graph contains more than {} values, with aliases expanded", kMaxGraphValues),
         std::move(at), "move data to separate files and refer to them in the graph");
  }

  // Counts values before they are read. Returns false once there are too many, and reports that once.
  bool take(std::size_t values, const YAML::Node& at) {
    if (values_ > kMaxGraphValues) return false;
    values_ += values;
    if (values_ > kMaxGraphValues) fail_too_large(place(at.Mark()));
    return values_ <= kMaxGraphValues;
  }

  // Calls `use` once for every key. Reports duplicate keys, and keys that are not in `known` unless it is
  // empty.
  void each_key(const YAML::Node& map, const std::vector<std::string>& known, const std::string& where,
                const std::function<void(const std::string&, const YAML::Node&, const YAML::Node&)>& use) {
    if (map.IsNull()) return;
    if (!map.IsMap()) return fail("not-a-map", where + " must be a map of 'name: value'", place(map.Mark()));
    std::set<std::string> seen;
    for (const auto& pair : map) {
      if (!take(1, map)) return;
      if (!pair.first.IsScalar()) {
        fail("bad-key", "a key must be a word", place(pair.first.Mark()));
        continue;
      }
      const std::string key = pair.first.Scalar();
      if (!seen.insert(key).second) {
        fail("duplicate-key", fmt::format("'{}' appears twice in {}", key, where), place(pair.first.Mark()));
        continue;
      }
      if (!known.empty() && std::find(known.begin(), known.end(), key) == known.end()) {
        fail("unknown-key", fmt::format("{} has no key '{}'{}", where, key, did_you_mean(key, known)),
             place(pair.first.Mark()));
        continue;
      }
      use(key, pair.first, pair.second);
    }
  }

  void read_version(const YAML::Node& v, const YAML::Node& key) {
    const int version = v.IsScalar() ? number_in_text<int>(v.Scalar()).value_or(0) : 0;
    if (version == kGraphFormat) return;
    fail("format-version",
         fmt::format("format version '{}' is not supported", v.IsScalar() ? v.Scalar() : "?"),
         place(key.Mark()),
         version > kGraphFormat ? "the file needs a newer version of Terrazzo"
                                : fmt::format("this program reads version {}", kGraphFormat));
  }

  bool read_value(const YAML::Node& v, RawValue& out, const std::string& what, const YAML::Node& key) {
    out.place = place(v.Mark());
    if (v.IsScalar()) {
      out.written = {false, {v.Scalar()}, {}};
      return true;
    }
    if (v.IsSequence() && !take(v.size(), v)) return false;
    if (v.IsSequence() && std::all_of(v.begin(), v.end(), [](const YAML::Node& n) { return n.IsScalar(); })) {
      out.written.is_list = true;
      for (const auto& item : v) {
        out.written.items.push_back(item.Scalar());
        out.written.places.emplace_back(item.Mark().line + 1, item.Mark().column + 1);
      }
      return true;
    }
    // Finding the line takes a while, so not for thousands of values.
    constexpr std::size_t kMostSearches = 100;
    const int line = key.Mark().line + 1;
    const auto items = v.IsSequence() ? static_cast<int>(v.size()) : 0;
    std::optional<YamlMistake> mistake;
    if (found_.size() < kMostSearches) mistake = commented_color(text_, line, line + items);
    if (mistake)
      fail("yaml", mistake->message, place(text_, mistake->at), mistake->hint);
    else
      fail("bad-value", fmt::format("'{}' must be a value or a list of values", what),
           v.IsNull() ? place(key.Mark()) : out.place);
    return false;
  }

  void read_parameter_(const std::string& name, const YAML::Node& key, const YAML::Node& v) {
    static const std::map<std::string, ParameterKind> kinds = {
        {"path", ParameterKind::InputPath}, {"int", ParameterKind::Int},
        {"number", ParameterKind::Number},  {"bool", ParameterKind::Bool},
        {"text", ParameterKind::Text},      {"choice", ParameterKind::Choice},
        {"color", ParameterKind::Color},    {"numbers", ParameterKind::Numbers},
        {"ints", ParameterKind::Ints},      {"texts", ParameterKind::Texts}};
    RawParameter p;
    p.declaration.name = name;
    p.place = place(key.Mark());
    bool has_type = false;
    const auto number = [&](const YAML::Node& n, double& out) {
      const auto value = n.IsScalar() ? read_number(n.Scalar()) : std::nullopt;
      if (!value || !std::isfinite(*value))
        return fail("bad-value", "min and max must be numbers", place(n.Mark()));
      out = *value;
    };
    each_key(v, {"type", "default", "doc", "unit", "min", "max", "choices", "keywords"},
             "parameter '" + name + "'",
             [&](const std::string& k, const YAML::Node& nk, const YAML::Node& n) {
               RawValue list;
               if (k == "type") {
                 has_type = true;
                 const auto it = kinds.find(n.IsScalar() ? n.Scalar() : "");
                 if (it != kinds.end()) {
                   p.declaration.kind = it->second;
                 } else {
                   std::vector<std::string> names;
                   for (const auto& [word, kind] : kinds) names.push_back(word);
                   const std::string word = n.IsScalar() ? n.Scalar() : "?";
                   fail("unknown-type",
                        fmt::format("parameter '{}' has the unknown type '{}'{}", name, word,
                                    did_you_mean(word, names)),
                        place(n.Mark()), fmt::format("use one of {}", fmt::join(names, ", ")));
                 }
               } else if (k == "default") {
                 read_value(n, p.value, name, nk);
               } else if (k == "doc" && n.IsScalar()) {
                 p.declaration.doc = n.Scalar();
               } else if (k == "unit" && n.IsScalar()) {
                 p.declaration.unit = n.Scalar();
               } else if (k == "min") {
                 number(n, p.declaration.min);
               } else if (k == "max") {
                 number(n, p.declaration.max);
               } else if (k == "choices" && read_value(n, list, k, nk)) {
                 p.declaration.choices = list.written.items;
               } else if (k == "keywords" && read_value(n, list, k, nk)) {
                 p.declaration.keywords = list.written.items;
               }
             });
    if (!has_type) fail("no-type", fmt::format("parameter '{}' needs a type", name), p.place);
    doc_.parameters.push_back(std::move(p));
  }

  void read_node(const std::string& name, const YAML::Node& key, const YAML::Node& v) {
    RawNode node;
    node.name = name;
    node.place = node.kind_place = place(key.Mark());
    if (!is_node_name(name))
      fail("bad-name",
           fmt::format("'{}' is not a valid node name: it must not be empty or contain dots, spaces or "
                       "control characters",
                       name),
           node.place);
    each_key(
        v, {"type", "graph", "bypass", "may_fail", "each", "params", "inputs", "doc"}, "node '" + name + "'",
        [&](const std::string& k, const YAML::Node& kn, const YAML::Node& n) {
          if ((k == "type" || k == "graph") && n.IsScalar()) {
            (k == "type" ? node.type : node.graph) = n.Scalar();
            node.kind_place = place(n.Mark());
          } else if (k == "params" || k == "each") {
            auto& values = k == "params" ? node.params : node.each;
            each_key(n, {}, k + " of '" + name + "'", [&](const auto& pname, const auto& pk, const auto& pv) {
              RawValue value;
              if (read_value(pv, value, pname, pk)) {
                if (value.place.line <= 0) value.place = place(pk.Mark());
                values.push_back({pname, std::move(value)});
              }
            });
            if (k == "each" && (n.IsNull() || (n.IsMap() && n.size() == 0)))
              fail("bad-value", fmt::format("each of '{}' is empty", name), place(kn.Mark()),
                   "write each: {NAME: [VALUE, …]} or each: {NAME: LO:HI:STEP}");
          } else if (k == "inputs") {
            each_key(n, {}, "inputs of '" + name + "'", [&](const auto& port, const auto&, const auto& pv) {
              std::vector<RawReference> wires;
              if (pv.IsScalar()) wires.push_back({pv.Scalar(), place(pv.Mark())});
              if (pv.IsSequence() && !take(pv.size(), pv)) return;
              if (pv.IsSequence())
                for (const auto& item : pv)
                  if (item.IsScalar()) wires.push_back({item.Scalar(), place(item.Mark())});
              if (wires.empty())
                fail("bad-reference", fmt::format("input '{}' must be NODE.PORT or a list of them", port),
                     place(pv.Mark()));
              else
                node.inputs.push_back({port, std::move(wires)});
            });
          } else if (k == "doc" && n.IsScalar()) {
            node.doc = n.Scalar();
          } else if (k == "bypass" || k == "may_fail") {
            if (!n.IsScalar() || (n.Scalar() != "true" && n.Scalar() != "false"))
              return fail("bad-value", fmt::format("{} of '{}' must be true or false", k, name),
                          place(kn.Mark()));
            (k == "bypass" ? node.bypass : node.may_fail) = n.Scalar() == "true";
          } else if (k != "doc") {
            fail("bad-value", fmt::format("'{}' must be a word", k), place(kn.Mark()));
          }
        });
    if (node.type.empty() == node.graph.empty())
      fail("no-type", fmt::format("node '{}' needs either a type or a graph", name), node.place);
    else
      doc_.nodes.push_back(std::move(node));
  }

  RawDocument doc_;
  std::string text_;
  Diagnostics& found_;
  std::size_t values_ = 0;  // read so far
};

}  // namespace

RawDocument read_document(const std::string& text, const std::filesystem::path& file, Diagnostics& found) {
  return DocumentReader(file, found).read(text);
}

WrittenValue read_written(const std::string& text) {
  // A list with a color that YAML takes for a comment does not end.
  const bool comment = text.starts_with('[') && text.find('#') != std::string::npos;
  const std::string hint = comment ? "put colors in quotes: [\"#c0b8a8\"]" : "";
  try {
    // YAML would treat a leading # as a comment, but colors start with one.
    const YAML::Node v = !text.empty() && text[0] == '#' ? YAML::Node(text) : YAML::Load(text);
    if (v.IsScalar()) return {false, {v.Scalar()}, {}};
    if (v.IsSequence()) {
      WrittenValue out{true, {}, {}};
      for (const auto& item : v) {
        if (!item.IsScalar()) throw Error("bad-value", "'" + text + "' is not a value or a list of values");
        out.items.push_back(item.Scalar());
      }
      return out;
    }
    if (v.IsNull()) return {false, {text}, {}};
  } catch (const YAML::Exception&) {
  }
  constexpr std::size_t kLongest = 200;  // bytes of a quotation
  const std::string shown = text.size() <= kLongest ? text : valid_utf8(text.substr(0, kLongest)) + "…";
  throw Error("bad-value", "'" + shown + "' is not a value or a list of values", hint);
}

}  // namespace terrazzo
