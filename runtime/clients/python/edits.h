// What the edits of a graph share.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "graph/node_type.h"
#include "graph/parameter.h"
#include "runtime/clients/python/bind.h"

namespace terrazzo::python {

// Whether a written value contains "${NAME}".
bool is_reference(const std::string& text);

// Paths that the user gives are relative to the working folder now, wherever the graph is saved later.
void make_absolute(const Parameter&, WrittenValue&);

// The values that a node is repeated for: a list, a range, "LO:HI:STEP", or a parameter of the graph.
WrittenValue written_values(const py::handle&);

// Checks a value as the linker does, unless it refers to a parameter of the graph. Throws Error "bad-value".
void check_value(const Parameter&, const WrittenValue&);

// Throws Error "bad-name" if no node or parameter may have this name.
void check_name(const std::string&);

[[noreturn]] void unknown_name(const NodeType&, const std::string& name);

// The input of this name, unless there is also a parameter of this name and the value is one for it: outputs
// and values go to the input, everything else to the parameter.
const Port* input_for(const NodeType&, const std::string& name, const py::object& value);

template <class Item>
void put(std::vector<std::pair<std::string, Item>>& list, const std::string& name, Item value) {
  for (auto& [known, v] : list)
    if (known == name) {
      v = std::move(value);
      return;
    }
  list.emplace_back(name, std::move(value));
}

template <class Item>
void erase(std::vector<std::pair<std::string, Item>>& list, const std::string& name) {
  std::erase_if(list, [&](const auto& entry) { return entry.first == name; });
}

}  // namespace terrazzo::python
