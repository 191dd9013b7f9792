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
  if (later_.count(name)) undeclared("list() on the input '" + name + "', whose values only nth() gives");
  const auto it = inputs_.find(name);
  return it == inputs_.end() ? none : it->second;
}

std::size_t Context::count(const std::string& name) const {
  const auto it = later_.find(name);
  return it == later_.end() ? list(name).size() : it->second.size();
}

Value Context::nth(const std::string& name, std::size_t i) const {
  const auto it = later_.find(name);
  return it == later_.end() ? list(name).at(i) : it->second.at(i)();
}

const std::vector<std::filesystem::path>& Context::files(const std::string& name) const {
  const auto it = files_.find(name);
  if (it == files_.end()) undeclared("the files of '" + name + "', which is not an input path");
  return it->second;
}

}  // namespace terrazzo
