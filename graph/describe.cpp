#include "graph/describe.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "graph/text/element_name.h"

namespace terrazzo {
using nlohmann::json;

namespace {

json value_json(const ParameterValue& v) {
  return std::visit([](const auto& x) { return json(x); }, v);
}

}  // namespace

std::string range_text(const Parameter& p) {
  std::string out;
  if (!p.choices.empty()) out = fmt::format("{}", fmt::join(p.choices, ", "));
  const auto add = [&](const std::string& s) { out += (out.empty() ? "" : "; ") + s; };
  if (std::isfinite(p.min) && std::isfinite(p.max))
    add(fmt::format("{}{} to {}", p.min_open ? "above " : "", p.min, p.max));
  else if (std::isfinite(p.min))
    add(fmt::format("{} {}", p.min_open ? "above" : "at least", p.min));
  else if (std::isfinite(p.max))
    add(fmt::format("at most {}", p.max));
  if (!p.keywords.empty()) add(fmt::format("or {}", fmt::join(p.keywords, ", ")));
  return out;
}

json describe_json(const NodeType& t) {
  const auto ports = [](const std::vector<Port>& list) {
    json out = json::array();
    for (const auto& p : list)
      out.push_back(
          {{"name", p.name}, {"types", p.types}, {"doc", p.doc}, {"optional", p.optional}, {"many", p.many}});
    return out;
  };
  json parameters = json::array();
  for (const auto& p : t.parameters) {
    json j = {{"name", p.name},        {"kind", name_of(p.kind)},          {"doc", p.doc},
              {"unit", p.unit},        {"required", !p.value.has_value()}, {"choices", p.choices},
              {"keywords", p.keywords}};
    if (p.value) j["default"] = value_json(*p.value);
    if (std::isfinite(p.min)) j["min"] = p.min;
    if (std::isfinite(p.max)) j["max"] = p.max;
    if (p.min_open) j["min_open"] = true;
    parameters.push_back(std::move(j));
  }
  return {{"type", t.name},
          {"version", t.version},
          {"doc", t.doc},
          {"source", t.source},
          {"district", t.district},
          {"writes_files", t.writes_files},
          {"inputs", ports(t.inputs)},
          {"outputs", ports(t.outputs)},
          {"parameters", parameters}};
}

std::string describe_text(const NodeType& t) {
  std::string out = fmt::format("{} (version {})\n  {}\n", t.name, t.version, t.doc);
  if (!t.source.empty()) out += fmt::format("  Source: {}\n", t.source);
  const auto ports = [&](const char* title, const std::vector<Port>& list) {
    if (list.empty()) return;
    out += fmt::format("{}\n", title);
    for (const auto& p : list)
      out += fmt::format("  {:<16} {}{}{}: {}\n", p.name, p.type_text(), p.many ? ", list" : "",
                         p.optional ? ", optional" : "", p.doc);
  };
  ports("Inputs", t.inputs);
  ports("Outputs", t.outputs);
  if (!t.parameters.empty()) out += "Parameters\n";
  for (const auto& p : t.parameters) {
    const std::string value = p.value ? written(*p.value) : "required";
    const std::string range = range_text(p);
    out +=
        fmt::format("  {:<16} {} = {}{}{}\n{:19}{}\n", p.name, name_of(p.kind), value,
                    p.unit.empty() ? "" : " " + p.unit, range.empty() ? "" : " (" + range + ")", "", p.doc);
  }
  return out;
}

std::string describe_markdown(const NodeType& t) {
  std::string out = fmt::format("# {}\n\n{}\n\n", t.name, t.doc);
  if (!t.source.empty()) out += fmt::format("Source: {}\n\n", t.source);
  const auto ports = [&](const char* title, const std::vector<Port>& list) {
    if (list.empty()) return;
    out += fmt::format("## {}\n\n| name | type | |\n|---|---|---|\n", title);
    for (const auto& p : list)
      out += fmt::format("| `{}` | {}{}{} | {} |\n", p.name, p.type_text(), p.many ? " (list)" : "",
                         p.optional ? " (optional)" : "", p.doc);
    out += "\n";
  };
  ports("Inputs", t.inputs);
  ports("Outputs", t.outputs);
  if (!t.parameters.empty()) {
    out += "## Parameters\n\n| name | kind | default | unit | range | |\n|---|---|---|---|---|---|\n";
    for (const auto& p : t.parameters)
      out += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", p.name, name_of(p.kind),
                         p.value ? "`" + written(*p.value) + "`" : "required", p.unit, range_text(p), p.doc);
  }
  return out;
}

NodeType describe_graph(const Graph& g) {
  NodeType t(g.name, 1);
  t.doc = g.doc.empty() ? "Graph " + g.file : g.doc;
  t.inputs = g.inputs;
  for (const auto& p : g.parameters) t.parameters.push_back(p.declaration);
  for (const auto& o : g.outputs) {
    const std::string name = without_elements(o.name);
    if (name != o.name && !t.outputs.empty() && t.outputs.back().name == name) continue;
    const Port& port = *g.nodes[o.wire.node].type->find_output(o.wire.port);
    t.outputs.push_back(port);
    t.outputs.back().name = name;
    t.outputs.back().many = name != o.name;
  }
  return t;
}

namespace {

json parameter_schema(const Parameter& p) {
  json reference = {{"type", "string"}, {"pattern", "\\$\\{[^}]+\\}"}};
  json plain;
  const auto number = [&](const char* type) {
    json j = {{"type", type}};
    if (std::isfinite(p.min)) j[p.min_open ? "exclusiveMinimum" : "minimum"] = p.min;
    if (std::isfinite(p.max)) j["maximum"] = p.max;
    return j;
  };
  const auto list_of = [&](json item) {
    json list = {{"type", "array"}, {"items", item}, {"minItems", p.min_count}, {"maxItems", p.max_count}};
    return p.min_count <= 1 ? json{{"anyOf", {item, list}}} : list;
  };
  switch (p.kind) {
    case ParameterKind::Bool:
      plain = {{"type", "boolean"}};
      break;
    case ParameterKind::Int:
      plain = number("integer");
      break;
    case ParameterKind::Number:
      plain = number("number");
      break;
    case ParameterKind::Choice:
      plain = {{"enum", p.choices}};
      break;
    case ParameterKind::Ints:
      plain = list_of(number("integer"));
      break;
    case ParameterKind::Numbers:
      plain = list_of(number("number"));
      break;
    case ParameterKind::Texts:
      plain = list_of(p.choices.empty() ? json{{"type", "string"}} : json{{"enum", p.choices}});
      break;
    case ParameterKind::Color:
      plain = {
          {"anyOf",
           {json{{"type", "string"}, {"pattern", "^#[0-9a-fA-F]{6}$"}},
            json{{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 3}, {"maxItems", 3}}}}};
      break;
    default:
      plain = {{"type", "string"}};
  }
  json any = json::array({plain, reference});
  if (!p.keywords.empty()) any.push_back({{"enum", p.keywords}});
  json out = {{"anyOf", any}, {"description", p.doc + (p.unit.empty() ? "" : " [" + p.unit + "]")}};
  if (p.value) out["default"] = value_json(*p.value);
  return out;
}

json each_schema() {
  const json value = {{"type", {"string", "number", "boolean"}}};
  return {
      {"type", "object"},
      {"description",
       "Repeats the node once per value. Parameters and wires contain the value as ${NAME}; several names "
       "give all combinations. A list of values, or LO:HI:STEP."},
      {"minProperties", 1},
      {"propertyNames", {{"pattern", "^[A-Za-z_][A-Za-z0-9_]*$"}}},
      {"additionalProperties", {{"anyOf", {value, {{"type", "array"}, {"items", value}, {"minItems", 1}}}}}}};
}

json node_schema(const NodeType& t) {
  json params = json::object(), inputs = json::object(), required_inputs = json::array(),
       required_params = json::array();
  for (const auto& p : t.parameters) {
    params[p.name] = parameter_schema(p);
    if (!p.value) required_params.push_back(p.name);
  }
  for (const auto& p : t.inputs) {
    json wire = {{"type", "string"}};
    inputs[p.name] = {{"description", p.doc + " (" + p.type_text() + ")"},
                      {"anyOf", p.many ? json::array({wire, json{{"type", "array"}, {"items", wire}}})
                                       : json::array({wire})}};
    if (!p.optional) required_inputs.push_back(p.name);
  }
  json schema = {{"type", "object"},
                 {"description", t.doc},
                 {"properties",
                  {{"type", {{"const", t.name}}},
                   {"doc", {{"type", "string"}}},
                   {"bypass", {{"type", "boolean"}}},
                   {"may_fail", {{"type", "boolean"}}},
                   {"each", each_schema()},
                   {"params",
                    {{"type", "object"},
                     {"properties", params},
                     {"required", required_params},
                     {"additionalProperties", false}}},
                   {"inputs",
                    {{"type", "object"},
                     {"properties", inputs},
                     {"required", required_inputs},
                     {"additionalProperties", false}}}}},
                 {"required", {"type"}},
                 {"additionalProperties", false}};
  if (!required_inputs.empty()) schema["required"].push_back("inputs");
  if (!required_params.empty()) schema["required"].push_back("params");
  return schema;
}

json subgraph_schema() {
  return {{"type", "object"},
          {"description", "A graph used as a node"},
          {"properties",
           {{"graph", {{"type", "string"}}},
            {"doc", {{"type", "string"}}},
            {"may_fail", {{"type", "boolean"}}},
            {"each", each_schema()},
            {"params", {{"type", "object"}}},
            {"inputs", {{"type", "object"}}}}},
          {"required", {"graph"}},
          {"additionalProperties", false}};
}

// Of a parameter that a graph declares.
json declaration_schema() {
  return {{"type", "object"},
          {"properties",
           {{"type",
             {{"enum",
               {"path", "int", "number", "bool", "text", "choice", "color", "numbers", "ints", "texts"}}}},
            {"default", json::object()},
            {"doc", {{"type", "string"}}},
            {"unit", {{"type", "string"}}},
            {"min", {{"type", "number"}}},
            {"max", {{"type", "number"}}},
            {"choices", {{"type", "array"}}},
            {"keywords", {{"type", "array"}}}}},
          {"required", {"type"}},
          {"additionalProperties", false}};
}

}  // namespace

json graph_schema(const Registry& registry) {
  json node_types = json::array();
  for (const NodeType* t : registry.all()) node_types.push_back(node_schema(*t));
  node_types.push_back(subgraph_schema());
  const json reference_map = {{"type", "object"}, {"additionalProperties", {{"type", "string"}}}};
  return {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
          {"title", "Terrazzo graph"},
          {"type", "object"},
          {"properties",
           {{"terrazzo", {{"const", 1}, {"description", "Format version"}}},
            {"name", {{"type", "string"}}},
            {"doc", {{"type", "string"}}},
            {"parameters", {{"type", "object"}, {"additionalProperties", declaration_schema()}}},
            {"nodes", {{"type", "object"}, {"additionalProperties", {{"anyOf", node_types}}}}},
            {"inputs", reference_map},
            {"outputs", reference_map}}},
          {"required", {"terrazzo", "nodes"}},
          {"additionalProperties", false}};
}

}  // namespace terrazzo
