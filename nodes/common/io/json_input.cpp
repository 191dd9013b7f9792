#include "nodes/common/io/json_input.h"

#include <fmt/format.h>

#include "nodes/common/io/reading.h"
#include "runtime/context.h"

namespace terrazzo {

nlohmann::json parse_json(const std::string& text, const std::string& inner, const JsonSource& source) {
  nlohmann::json json;
  try {
    json = terrazzo::parse_json(text);
  } catch (const Error& e) {
    throw Error("unreadable-file",
                fmt::format("'{}' is not JSON: {}", source.file, printable(e.diagnostic().message)),
                source.hint)
        .parameter("path");
  }
  const auto it = json.find(inner);  // end() if it is no object
  if (it == json.end() || !it->is_object()) return json;
  nlohmann::json out = std::move(*it);
  return out;
}

std::string json_text_in(Context& c) {
  const auto& files = c.files("path");
  if (files.size() != 1)
    throw Error("several-files", fmt::format("the path matches {} files; one is needed", files.size()),
                "name one file")
        .parameter("path");
  try {
    std::string text = read_whole(files[0], reading_of(c));
    require_memory(text.size() + memory_to_read_json(text), c.memory(),
                   "the file '" + files[0].string() + "'");
    return text;
  } catch (Error& e) {
    throw e.parameter("path");
  }
}

JsonObject::JsonObject(const nlohmann::json& json, const JsonSource& source, std::string what,
                       const char* code)
    : json_(json), source_(source), what_(std::move(what)), code_(code) {
  if (!json.is_object()) fail("is not an object");
}

void JsonObject::fail(const std::string& what) const {
  throw Error(code_, fmt::format("'{}': {}{}", source_.file, what_, what), source_.hint).parameter("path");
}

void JsonObject::fail_too_large(const char* name) const {
  fail(fmt::format("the field {} has a number that is too large", name));
}

const nlohmann::json& JsonObject::field(const char* name) const {
  const auto it = json_.find(name);
  if (it == json_.end()) fail(fmt::format("has no field {}", name));
  return *it;
}

const nlohmann::json& JsonObject::list(const char* name) const {
  const nlohmann::json& v = field(name);
  if (!v.is_array()) fail(fmt::format("the field {} is not a list", name));
  return v;
}

std::string JsonObject::text(const char* name) const {
  const nlohmann::json& v = field(name);
  if (!v.is_string()) fail(fmt::format("the field {} is not text", name));
  return v.get<std::string>();
}

bool JsonObject::boolean(const char* name) const {
  const nlohmann::json& v = field(name);
  if (!v.is_boolean()) fail(fmt::format("the field {} is not true or false", name));
  return v.get<bool>();
}

double JsonObject::number(const char* name, double least, double most) const {
  const nlohmann::json& v = field(name);
  if (!v.is_number()) fail(fmt::format("the field {} is not a number", name));
  return number_in(name, v, least, most);
}

int JsonObject::whole(const char* name, int least, int most) const {
  const double v = number(name, least, most);
  if (v != std::floor(v)) fail(fmt::format("the field {} is not a whole number", name));
  return static_cast<int>(v);
}

std::vector<double> JsonObject::numbers(const char* name, double least, double most) const {
  const nlohmann::json& all = list(name);
  std::vector<double> out;
  out.reserve(all.size());
  for (const nlohmann::json& v : all) out.push_back(number_in(name, v, least, most));
  return out;
}

double JsonObject::number_in(const char* name, const nlohmann::json& v, double least, double most) const {
  if (!v.is_number()) fail(fmt::format("the field {} contains something else than numbers", name));
  const auto n = v.get<double>();
  if (n >= least && n <= most) return n;
  if (most == kLargest)
    fail(fmt::format("the field {} has the number {:g}; it must be {} {:g}", name, n,
                     least == kSmallest ? "above" : "at least", least == kSmallest ? 0 : least));
  fail(fmt::format("the field {} has the number {:g}; it must be from {:g} to {:g}", name, n, least, most));
}

void JsonObject::require_size(const char* name, const nlohmann::json& element, std::size_t size) const {
  if (!element.is_array() || element.size() != size)
    fail(fmt::format("the field {} needs lists of {} numbers", name, size));
}

}  // namespace terrazzo
