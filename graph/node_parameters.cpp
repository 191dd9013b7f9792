#include "graph/node_parameters.h"

#include <algorithm>

#include "graph/diagnostic.h"
#include "graph/node_type.h"

namespace terrazzo {
namespace {

// Using something undeclared is a bug in the node, not an error of the user.
[[noreturn]] void misused(const std::string& name, const std::string& how) {
  throw Error("node-bug", "the node uses the parameter '" + name + "'" + how);
}

template <class T>
const T& get(const ParameterValue& v, const std::string& name) {
  if (const T* x = std::get_if<T>(&v)) return *x;
  misused(name, " with the wrong kind (its value is " + canonical(v) + ")");
}

}  // namespace

NodeParameters::NodeParameters(const NodeType& type, std::map<std::string, ParameterValue> set)
    : type_(&type), parameters_(std::move(set)) {
  for (const Parameter& p : type.parameters)
    if (p.value) parameters_.emplace(p.name, *p.value);
}

const ParameterValue& NodeParameters::raw(const std::string& name) const {
  const auto it = parameters_.find(name);
  if (it == parameters_.end()) misused(name, ", which it does not declare");
  return it->second;
}

bool NodeParameters::boolean(const std::string& n) const { return get<bool>(raw(n), n); }
std::int64_t NodeParameters::integer(const std::string& n) const { return get<std::int64_t>(raw(n), n); }
double NodeParameters::number(const std::string& n) const { return get<double>(raw(n), n); }
std::string NodeParameters::text(const std::string& n) const { return get<std::string>(raw(n), n); }
std::vector<std::int64_t> NodeParameters::ints(const std::string& n) const {
  return get<std::vector<std::int64_t>>(raw(n), n);
}
std::vector<double> NodeParameters::numbers(const std::string& n) const {
  return get<std::vector<double>>(raw(n), n);
}
std::vector<std::string> NodeParameters::texts(const std::string& n) const {
  return get<std::vector<std::string>>(raw(n), n);
}

std::string NodeParameters::keyword(const std::string& n) const {
  const auto* s = std::get_if<std::string>(&raw(n));
  if (!s) return "";
  const auto& words = type_->find_parameter(n)->keywords;
  return std::find(words.begin(), words.end(), *s) != words.end() ? *s : "";
}

std::optional<std::int64_t> NodeParameters::optional_integer(const std::string& n) const {
  if (!keyword(n).empty()) return {};
  return integer(n);
}

std::optional<double> NodeParameters::optional_number(const std::string& n) const {
  if (!keyword(n).empty()) return {};
  return number(n);
}

int NodeParameters::choice_index(const std::string& n) const {
  const std::string value = text(n);
  const Parameter* p = type_ ? type_->find_parameter(n) : nullptr;
  if (!p || p->kind != ParameterKind::Choice) misused(n, " as a choice");
  const auto at = std::find(p->choices.begin(), p->choices.end(), value);
  if (at == p->choices.end()) misused(n, " with a value that is not a choice");
  return at - p->choices.begin();
}

}  // namespace terrazzo
