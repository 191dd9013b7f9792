#include "runtime/given.h"

#include <fmt/format.h>
#include <zlib.h>

#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "runtime/context.h"
#include "runtime/files/base64.h"

namespace terrazzo {
namespace {

constexpr std::size_t kMostBytes = 128 << 10;        // of a value in provenance, compressed
constexpr std::size_t kMostTogether = 512 << 10;     // of all of them
constexpr std::size_t kMostUncompressed = 64 << 20;  // of all of them

std::mutex mutex;
struct Table {
  std::map<std::string, std::weak_ptr<const GivenValue>> values;  // by content
  std::set<std::string> types;                                    // of nodes
};
Table& table() {
  static auto& all = *new Table;
  return all;
}

// Sets the output of the node to the value with the content that its parameter names.
void compute(Context& c) {
  const std::string content = c.text("content");
  const auto found = find_given(content);
  if (!found)
    throw Error("no-value", "the value " + content + " was given in another process",
                "pass the array again with terrazzo.image, labels, mesh or sizes");
  c.output("value", found->value);
}

std::string compressed(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string out(size, '\0');
  compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
            bytes.size(), 9);
  out.resize(size);
  return out;
}

Error damaged(const std::string& content) {
  return Error("damaged", "the provenance contains a damaged array: " + content.substr(0, 40));
}

// `room`: bytes that the values may still take.
Value value_from(const std::string& content, const nlohmann::json& j, const ValueTypes& types,
                 std::size_t& room) {
  std::string packed;
  const auto size = j.at("bytes").get<std::uint64_t>();
  if (size > room || !decode_base64(j.at("data").get_ref<const std::string&>(), packed))
    throw damaged(content);
  room -= size;
  std::string bytes(size, '\0');
  uLongf written = size;
  if (uncompress(reinterpret_cast<Bytef*>(bytes.data()), &written,
                 reinterpret_cast<const Bytef*>(packed.data()), packed.size()) != Z_OK ||
      written != size)
    throw damaged(content);
  const ValueType* type = types.find(j.at("type").get<std::string>());
  if (!type) throw damaged(content);
  Reader reader(bytes.data(), bytes.size());
  Value value(type, type->decode(reader));
  if (reader.left() > 0 || content_of(value).text() != content) throw damaged(content);
  return value;
}

const std::string* content_given_by(const GraphNode& node) {
  if (!is_given_type(node.type->name)) return nullptr;
  const auto it = node.parameters.find("content");
  return it == node.parameters.end() ? nullptr : std::get_if<std::string>(&it->second.value);
}

}  // namespace

Hash content_of(const Value& v) {
  HashWriter w;
  w.text(v.type().name);
  v.type().encode(v.data(), w);
  return w.hash();
}

std::string given_type(const std::string& value_type) { return "Given" + value_type; }

bool is_given_type(const std::string& node_type) {
  const std::lock_guard lock(mutex);
  return table().types.count(node_type) > 0;
}

void register_given_types(Registry& registry, const ValueTypes& types) {
  for (const auto& name : types.names()) {
    registry.add(NodeType(given_type(name), 1)
                     .doc_("Gives a value that was made in Python")
                     .output("value", name, "The value")
                     .parameter(Parameter::text("content", "").doc_("Hash of the value's content"))
                     .compute_(compute));
    const std::lock_guard lock(mutex);
    table().types.insert(given_type(name));
  }
}

std::shared_ptr<const GivenValue> give_value(const Value& v) {
  const std::string content = content_of(v).text();
  const std::lock_guard lock(mutex);
  std::erase_if(table().values, [](const auto& entry) { return entry.second.expired(); });
  auto& place = table().values[content];
  auto kept = place.lock();
  if (!kept) place = kept = std::make_shared<const GivenValue>(GivenValue{v, content});
  return kept;
}

std::shared_ptr<const GivenValue> find_given(const std::string& content) {
  const std::lock_guard lock(mutex);
  const auto it = table().values.find(content);
  return it == table().values.end() ? nullptr : it->second.lock();
}

nlohmann::json given_values_json(const Graph& graph, const std::vector<bool>& needed) {
  nlohmann::json out = nlohmann::json::object();
  std::size_t together = 0, uncompressed = 0;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const std::string* content = content_given_by(graph.nodes[i]);
    const auto given = needed[i] && content && !out.contains(*content) ? find_given(*content) : nullptr;
    if (!given) continue;
    BufferWriter encoded;
    given->value.type().encode(given->value.data(), encoded);
    if (uncompressed + encoded.buffer.size() > kMostUncompressed) continue;
    const std::string packed = compressed({encoded.buffer.data(), encoded.buffer.size()});
    if (packed.size() > kMostBytes || together + packed.size() > kMostTogether) continue;
    together += packed.size();
    uncompressed += encoded.buffer.size();
    out[*content] = {{"type", given->value.type().name},
                     {"bytes", encoded.buffer.size()},
                     {"data", encode_base64(packed)}};
  }
  return out;
}

GivenValues give_values(const nlohmann::json& values, const ValueTypes& types) {
  GivenValues out;
  std::size_t room = kMostUncompressed;
  for (const auto& [content, j] : values.items())
    out.push_back(give_value(value_from(content, j, types, room)));
  return out;
}

void require_given_values(const Graph& graph, const std::string& file) {
  for (const GraphNode& node : graph.nodes) {
    const std::string* content = content_given_by(node);
    if (!content || find_given(*content)) continue;
    throw Error(
        "given-array",
        fmt::format("'{}' was made from an array that Python gave, '{}' ({}), which is too large for its "
                    "provenance",
                    file, node.path, node.type->outputs.front().types.front()),
        fmt::format("in the script that made it, graph.save(\"graph.yaml\", arrays=\"arrays\") writes the "
                    "array to arrays/{} and a graph that reads it",
                    node.path));
  }
}

}  // namespace terrazzo
