#include "graph/registry.h"

#include <algorithm>
#include <set>

#include "graph/diagnostic.h"

namespace terrazzo {
namespace {

void demand(bool ok, const NodeType& t, const std::string& what) {
  if (!ok) throw Error("bad-node-type", "node type " + t.name + ": " + what);
}

// Rejects incomplete declarations here, because they would lead to wrong keys, reference pages or messages
// later.
void check_declaration(const NodeType& t) {
  demand(!t.name.empty() && t.version >= 1 && t.compute, t,
         "needs a name, a version of at least 1 and a compute function");
  demand(!t.doc.empty(), t, "has no documentation");
  demand(!t.outputs.empty() || t.writes_files, t, "has no outputs and writes no files");
  std::set<std::string> inputs, outputs, parameters;
  for (const auto& p : t.inputs)
    demand(inputs.insert(p.name).second && !p.doc.empty(), t,
           "input '" + p.name + "' is duplicate or undocumented");
  for (const auto& p : t.outputs) {
    demand(outputs.insert(p.name).second && !p.doc.empty(), t,
           "output '" + p.name + "' is duplicate or undocumented");
    demand(p.types.size() == 1, t, "output '" + p.name + "' needs exactly one type");
  }
  for (const auto& p : t.parameters) {
    demand(parameters.insert(p.name).second && !p.doc.empty(), t,
           "parameter '" + p.name + "' is duplicate or undocumented");
    const auto is_word = [&](const std::string& w) {
      return std::count(p.choices.begin(), p.choices.end(), w) +
                 std::count(p.keywords.begin(), p.keywords.end(), w) >
             0;
    };
    for (const auto& [former, word] : p.former_words)
      demand(is_word(word) && !is_word(former), t,
             "parameter '" + p.name + "' replaces '" + former + "' by '" + word + "', which is not possible");
    std::string why;
    if (p.value && p.kind != ParameterKind::Color) {
      WrittenValue w;
      if (const auto* list = std::get_if<std::vector<double>>(&*p.value)) {
        for (const double v : *list) w.items.push_back(canonical(v));
        w.is_list = true;
      } else if (const auto* ints = std::get_if<std::vector<std::int64_t>>(&*p.value)) {
        for (const auto v : *ints) w.items.push_back(std::to_string(v));
        w.is_list = true;
      } else if (const auto* words = std::get_if<std::vector<std::string>>(&*p.value)) {
        w.items = *words;
        w.is_list = true;
      } else {
        w.items.push_back(written(*p.value));
      }
      demand(read_parameter(p, w, why).has_value(), t, "the default of '" + p.name + "' is invalid: " + why);
    }
  }
}

}  // namespace

void Registry::add(NodeType t) {
  check_declaration(t);
  std::string name = t.name;
  const std::string district = t.district;
  if (!types_.emplace(name, std::make_unique<NodeType>(std::move(t))).second)
    throw Error("duplicate-node-type", "there are two node types named " + name);
  if (!district.empty() && std::find(districts_.begin(), districts_.end(), district) == districts_.end())
    districts_.push_back(district);
}

void Registry::replace(NodeType t) {
  check_declaration(t);
  auto& place = types_[t.name];
  if (place) replaced_.push_back(std::move(place));
  place = std::make_unique<NodeType>(std::move(t));
}

const NodeType* Registry::find(const std::string& name) const {
  const auto it = types_.find(name);
  return it == types_.end() ? nullptr : it->second.get();
}

const NodeType* Registry::find_former(const std::string& name) const {
  for (const auto& [today, type] : types_)
    for (const auto& former : type->former_names)
      if (former == name) return type.get();
  return nullptr;
}

std::vector<const NodeType*> Registry::all() const {
  std::vector<const NodeType*> out;
  for (const auto& [name, type] : types_) out.push_back(type.get());
  return out;
}

std::vector<std::string> Registry::names() const {
  std::vector<std::string> out;
  for (const auto& [name, type] : types_) out.push_back(name);
  return out;
}

std::vector<Registry::District> Registry::by_district() const {
  std::vector<District> out;
  for (const auto& district : districts_) out.push_back({district, {}});
  District other{"other", {}};
  for (const auto& [name, type] : types_) {
    const auto at = std::find(districts_.begin(), districts_.end(), type->district);
    (at == districts_.end() ? other : out[at - districts_.begin()]).types.push_back(type.get());
  }
  if (!other.types.empty()) out.push_back(std::move(other));
  return out;
}

}  // namespace terrazzo
