// Fuzzes the cache's codecs. Any bytes decode to a value or to the error "damaged", and encoding a decoded
// value is stable under another round trip.
#include <cstdlib>

#include "nodes/register_nodes.h"
#include "runtime/cache/store.h"
#include "runtime/codec.h"

using namespace terrazzo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ValueTypes types = [] {
    ValueTypes t;
    register_value_types(t);
    return t;
  }();
  static const auto names = types.names();
  if (size == 0) return 0;
  // Records use a text format.
  if (data[0] == 255) {
    const std::string body(reinterpret_cast<const char*>(data) + 1, size - 1);
    parse_action(hash_of(body).text() + "\n" + body);
    return 0;
  }
  const ValueType& type = *types.find(names[data[0] % names.size()]);
  try {
    Reader reader(data + 1, size - 1);
    const auto value = type.decode(reader);
    BufferWriter once;
    type.encode(value.get(), once);
    Reader back(once.buffer.data(), once.buffer.size());
    BufferWriter twice;
    type.encode(type.decode(back).get(), twice);
    if (once.buffer != twice.buffer) std::abort();
  } catch (const Error&) {
  }
  return 0;
}
