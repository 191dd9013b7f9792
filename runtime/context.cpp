#include "runtime/context.h"

namespace terrazzo {
namespace {

// Using something undeclared is a bug in the node, not an error of the user.
[[noreturn]] void undeclared(const std::string& what) { throw Error("node-bug", "the node uses " + what); }

}  // namespace

const Value* Context::find(const std::string& name) const {
  const auto it = inputs_.find(name);
  return it == inputs_.end() || it->second.empty() ? nullptr : &it->second.front();
}

const Value& Context::value(const std::string& name) const {
  if (const Value* v = find(name)) return *v;
  undeclared("the input '" + name + "', which is not connected");
}

const std::vector<Value>& Context::list(const std::string& name) const {
  static const std::vector<Value> none;
  const auto it = inputs_.find(name);
  return it == inputs_.end() ? none : it->second;
}

const ParameterValue& Context::raw(const std::string& name) const {
  const auto it = parameters_.find(name);
  if (it == parameters_.end()) undeclared("the parameter '" + name + "', which it does not declare");
  return it->second;
}

namespace {
template <class T>
const T& get(const ParameterValue& v, const std::string& name) {
  if (const T* x = std::get_if<T>(&v)) return *x;
  undeclared("the parameter '" + name + "' with the wrong kind (its value is " + canonical(v) + ")");
}
}  // namespace

bool Context::boolean(const std::string& n) const { return get<bool>(raw(n), n); }
std::int64_t Context::integer(const std::string& n) const { return get<std::int64_t>(raw(n), n); }
double Context::number(const std::string& n) const { return get<double>(raw(n), n); }
std::string Context::text(const std::string& n) const { return get<std::string>(raw(n), n); }
std::vector<std::int64_t> Context::ints(const std::string& n) const {
  return get<std::vector<std::int64_t>>(raw(n), n);
}
std::vector<double> Context::numbers(const std::string& n) const {
  return get<std::vector<double>>(raw(n), n);
}
std::vector<std::string> Context::texts(const std::string& n) const {
  return get<std::vector<std::string>>(raw(n), n);
}

std::string Context::keyword(const std::string& n) const {
  const auto* s = std::get_if<std::string>(&raw(n));
  return s ? *s : "";
}

const std::vector<std::filesystem::path>& Context::files(const std::string& name) const {
  const auto it = files_.find(name);
  if (it == files_.end()) undeclared("the files of '" + name + "', which is not an input path");
  return it->second;
}

}  // namespace terrazzo
