#include "runtime/cache/action_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "graph/node_type.h"
#include "graph/text/read_number.h"
#include "runtime/files/base64.h"

namespace terrazzo {
using nlohmann::json;

bool has_outputs_of(const ActionRecord& r, const NodeType& type) {
  return r.outputs.size() == type.outputs.size() &&
         std::all_of(type.outputs.begin(), type.outputs.end(), [&](const Port& port) {
           const auto it = r.outputs.find(port.name);
           return it != r.outputs.end() && port.accepts(it->second.type);
         });
}

namespace {

json to_json(const OutputRecord& o) {
  return {{"type", o.type}, {"content", o.content.text()}, {"bytes", o.bytes}};
}
json to_json(const FileRecord& f) { return {{"path", f.path}, {"content", f.content.text()}}; }

OutputRecord output_from(const json& j) {
  OutputRecord out{j.at("type"), Hash::parse(j.at("content").get<std::string>()), j.at("bytes")};
  // Absent in records of large values and of version 0.2, which gave every value a file.
  if (const auto value = j.find("value"); value != j.end()) {
    std::string bytes;
    if (!decode_base64(value->get_ref<const std::string&>(), bytes) || bytes.size() != out.bytes ||
        hash_of(bytes) != out.content)
      throw Error("damaged", "a cache entry contains a value that is not its output");
    out.small = std::make_shared<const std::string>(std::move(bytes));
  }
  return out;
}
FileRecord file_from(const json& j) {
  return {j.at("path"), Hash::parse(j.at("content").get<std::string>())};
}

double number_from(const json& j) {
  const auto value = read_number(j.get_ref<const std::string&>());
  if (!value) throw Error("damaged", "a cache entry has a metric that is not a number");
  return *value;
}

// Stores the kind along with the value, because an empty list does not reveal its element type.
json to_json(const ParameterValue& v) {
  json value = std::visit([](const auto& x) { return json(x); }, v);
  return json::array({v.index(), std::move(value)});
}

template <std::size_t I = 0>
ParameterValue parameter_from(const json& value, std::size_t kind) {
  if constexpr (I < std::variant_size_v<ParameterValue>) {
    if (kind == I) return value.get<std::variant_alternative_t<I, ParameterValue>>();
    return parameter_from<I + 1>(value, kind);
  } else {
    throw Error("damaged", "a cache entry has an unknown kind of parameter");
  }
}

}  // namespace

json to_json(const ActionRecord& r) {
  json outputs = json::object(), files = json::array(), metrics = json::object(), parameters = json::object(),
       inputs = json::object(), input_files = json::object();
  for (const auto& [port, o] : r.outputs) {
    outputs[port] = to_json(o);
    if (o.small) outputs[port]["value"] = encode_base64(*o.small);
  }
  for (const auto& f : r.files) files.push_back(to_json(f));
  for (const auto& [name, v] : r.metrics)
    metrics[name] = fmt::format("{}", v);  // keeps infinities and every digit
  for (const auto& [name, v] : r.parameters) parameters[name] = to_json(v);
  for (const auto& [port, list] : r.inputs)
    for (const auto& o : list) inputs[port].push_back(to_json(o));
  for (const auto& [name, list] : r.input_files)
    for (const auto& f : list) input_files[name].push_back(to_json(f));
  return {{"outputs", outputs},     {"metrics", metrics},
          {"warnings", r.warnings}, {"files", files},
          {"seconds", r.seconds},   {"type", r.type},
          {"version", r.version},   {"parameters", parameters},
          {"inputs", inputs},       {"input_files", input_files}};
}

ActionRecord action_record_from_json(const json& j) {
  ActionRecord r;
  for (const auto& [port, o] : j.at("outputs").items()) r.outputs[port] = output_from(o);
  for (const auto& [name, v] : j.at("metrics").items()) r.metrics[name] = number_from(v);
  r.warnings = j.at("warnings").get<std::vector<std::string>>();
  for (const auto& f : j.at("files")) r.files.push_back(file_from(f));
  r.seconds = j.at("seconds");
  r.type = j.at("type");
  r.version = j.at("version");
  for (const auto& [name, v] : j.at("parameters").items())
    r.parameters[name] = parameter_from(v.at(1), v.at(0).get<std::size_t>());
  for (const auto& [port, list] : j.at("inputs").items())
    for (const auto& o : list) r.inputs[port].push_back(output_from(o));
  for (const auto& [name, list] : j.at("input_files").items())
    for (const auto& f : list) r.input_files[name].push_back(file_from(f));
  return r;
}

}  // namespace terrazzo
