// A plugin with a node type and a value type, built against the installed headers.
#include <nlohmann/json.hpp>

#include "graph/node_type.h"
#include "runtime/context.h"
#include "runtime/plugin.h"

namespace outside {

struct Number {
  double value = 0;
};

}  // namespace outside

template <>
const terrazzo::ValueType& terrazzo::value_type<outside::Number>() {
  static const ValueType type = make_value_type<outside::Number>(
      "Number", "One number", [](const outside::Number& v, Writer& w) { w.pod(v.value); },
      [](Reader& r) { return outside::Number{r.pod<double>()}; },
      [](const outside::Number& v) {
        return nlohmann::json{{"value", v.value}};
      });
  return type;
}

TERRAZZO_PLUGIN(registry, types) {
  using namespace terrazzo;
  types.add(value_type<outside::Number>());
  registry.add(NodeType("Double", 1)
                   .doc_("Twice a number")
                   .output("number", "Number", "The result")
                   .parameter(Parameter::number("value", 21).range(-1e9, 1e9).doc_("What is doubled"))
                   .compute_([](Context& c) { c.output("number", outside::Number{2 * c.number("value")}); }));
}
