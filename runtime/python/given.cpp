#include "runtime/python/given.h"

#include <map>
#include <mutex>

#include "runtime/context.h"
#include "runtime/python/value_object.h"

namespace terrazzo::python {
namespace {

std::mutex mutex;
std::map<std::string, std::weak_ptr<const GivenValue>>& table() {
  static auto& all = *new std::map<std::string, std::weak_ptr<const GivenValue>>;
  return all;
}

class Given {
 public:
  // Sets the output of the node to the value with the content that its parameter names.
  static void compute(Context& c) {
    const std::string content = c.text("content");
    std::shared_ptr<const GivenValue> found;
    {
      const std::lock_guard lock(mutex);
      if (const auto it = table().find(content); it != table().end()) found = it->second.lock();
    }
    if (!found)
      throw Error("no-value", "the value " + content + " was given in another process",
                  "pass the array again with terrazzo.image, labels, mesh or sizes");
    c.output("value", found->value);
  }
};

}  // namespace

std::string given_type(const std::string& value_type) { return "Given" + value_type; }

bool is_given_type(const std::string& node_type) {
  return node_type.rfind("Given", 0) == 0 && value_types().find(node_type.substr(5));
}

void register_given_types(Registry& registry, const ValueTypes& types) {
  for (const auto& name : types.names())
    registry.add(NodeType(given_type(name), 1)
                     .doc_("Gives a value that was made in Python")
                     .output("value", name, "The value")
                     .parameter(Parameter::text("content", "").doc_("Hash of the value's content"))
                     .compute_(Given::compute));
}

std::shared_ptr<const GivenValue> give_value(const Value& v) {
  const std::string content = content_of(v).text();
  const std::lock_guard lock(mutex);
  std::erase_if(table(), [](const auto& entry) { return entry.second.expired(); });
  auto& place = table()[content];
  auto kept = place.lock();
  if (!kept) place = kept = std::make_shared<const GivenValue>(GivenValue{v, content});
  return kept;
}

}  // namespace terrazzo::python
