// Values that the user gives, such as arrays. A graph holds each as a node whose only parameter is the
// content's hash, so keys and caches treat it like the result of any other node.
#pragma once

#include <memory>
#include <string>

#include "runtime/python/bind.h"

namespace terrazzo::python {

struct GivenValue {
  Value value;
  std::string content;
};

// The node type that gives values of a type: "GivenImage".
std::string given_type(const std::string& value_type);
bool is_given_type(const std::string& node_type);
void register_given_types(Registry&, const ValueTypes&);

// Makes the value available to nodes as long as the result lives.
std::shared_ptr<const GivenValue> give_value(const Value&);

}  // namespace terrazzo::python
