#include "graph/node_type.h"

#include <algorithm>

namespace terrazzo {

bool Port::accepts(const std::string& type) const {
  return types.empty() || std::find(types.begin(), types.end(), type) != types.end();
}

std::string Port::type_text() const {
  if (types.empty()) return "any";
  std::string out = types[0];
  for (std::size_t i = 1; i < types.size(); ++i) out += (i + 1 == types.size() ? " or " : ", ") + types[i];
  return out;
}

NodeType::NodeType(std::string name, int version) : name(std::move(name)), version(version) {}
NodeType::NodeType(const NodeType&) = default;
NodeType::NodeType(NodeType&&) noexcept = default;
NodeType& NodeType::operator=(const NodeType&) = default;
NodeType& NodeType::operator=(NodeType&&) noexcept = default;
NodeType::~NodeType() = default;

NodeType& NodeType::doc_(std::string text) {
  doc = std::move(text);
  return *this;
}
NodeType& NodeType::source_(std::string text) {
  source = std::move(text);
  return *this;
}
NodeType& NodeType::input(std::string name, std::string type, std::string doc) {
  inputs.push_back({std::move(name), {std::move(type)}, std::move(doc), false, false, {}});
  return *this;
}
NodeType& NodeType::optional_input(std::string name, std::vector<std::string> types, std::string doc) {
  inputs.push_back({std::move(name), std::move(types), std::move(doc), true, false, {}});
  return *this;
}
NodeType& NodeType::input_list(std::string name, std::vector<std::string> types, std::string doc) {
  inputs.push_back({std::move(name), std::move(types), std::move(doc), false, true, {}});
  return *this;
}
NodeType& NodeType::one_at_a_time() {
  inputs.back().one_at_a_time = true;
  return *this;
}
NodeType& NodeType::output(std::string name, std::string type, std::string doc) {
  outputs.push_back({std::move(name), {std::move(type)}, std::move(doc), false, false, {}});
  return *this;
}
NodeType& NodeType::parameter(Parameter p) { return parameters.push_back(std::move(p)), *this; }
NodeType& NodeType::was(std::string former) { return former_names.push_back(std::move(former)), *this; }
NodeType& NodeType::input_was(std::string former) {
  return inputs.back().former_names.push_back(std::move(former)), *this;
}
NodeType& NodeType::output_was(std::string former) {
  return outputs.back().former_names.push_back(std::move(former)), *this;
}
NodeType& NodeType::writes_files_() {
  writes_files = true;
  return *this;
}
NodeType& NodeType::companion_files_(std::vector<std::filesystem::path> (*fn)(const std::filesystem::path&)) {
  companion_files = fn;
  return *this;
}

NodeType& NodeType::check_(void (*fn)(const NodeParameters&)) {
  check = fn;
  return *this;
}
NodeType& NodeType::compute_(void (*fn)(Context&)) {
  compute = fn;
  return *this;
}
NodeType& NodeType::in_district(std::string name) {
  district = std::move(name);
  return *this;
}

namespace {
template <class List>
auto find_by_name(const List& list, const std::string& name) -> decltype(list.data()) {
  for (const auto& x : list)
    if (x.name == name) return &x;
  return nullptr;
}

const Port* find_by_former_name(const std::vector<Port>& ports, const std::string& name) {
  for (const auto& p : ports)
    if (std::find(p.former_names.begin(), p.former_names.end(), name) != p.former_names.end()) return &p;
  return nullptr;
}
}  // namespace

const Port* NodeType::find_input(const std::string& n) const { return find_by_name(inputs, n); }
const Port* NodeType::find_output(const std::string& n) const { return find_by_name(outputs, n); }
const Port* NodeType::find_former_input(const std::string& n) const { return find_by_former_name(inputs, n); }
const Port* NodeType::find_former_output(const std::string& n) const {
  return find_by_former_name(outputs, n);
}
const Parameter* NodeType::find_parameter(const std::string& n) const { return find_by_name(parameters, n); }

}  // namespace terrazzo
