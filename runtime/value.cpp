#include "runtime/value.h"

namespace terrazzo {

void ValueTypes::add(const ValueType& t) { types_[t.name] = &t; }

const ValueType* ValueTypes::find(const std::string& name) const {
  const auto it = types_.find(name);
  return it == types_.end() ? nullptr : it->second;
}

std::vector<std::string> ValueTypes::names() const {
  std::vector<std::string> out;
  for (const auto& [name, type] : types_) out.push_back(name);
  return out;
}

}  // namespace terrazzo
