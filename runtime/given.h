// Values that the user gives, such as arrays in Python. A graph holds each as a node of a type such as
// "GivenImage" whose only parameter is the content's hash, so keys and caches treat it like the result of any
// other node.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "runtime/hash.h"
#include "runtime/value.h"

namespace terrazzo {

struct GivenValue {
  Value value;
  std::string content;
};
using GivenValues = std::vector<std::shared_ptr<const GivenValue>>;

// The hash of the type and the encoded value, as the store computes it.
Hash content_of(const Value&);

// The node type that gives values of a type: "GivenImage".
std::string given_type(const std::string& value_type);
bool is_given_type(const std::string& node_type);
void register_given_types(Registry&, const ValueTypes&);

// Makes the value available to nodes as long as the result lives.
std::shared_ptr<const GivenValue> give_value(const Value&);
// A value that was given and still lives, or null.
std::shared_ptr<const GivenValue> find_given(const std::string& content);

// Small values that the graph's nodes give, for provenance: type and compressed bytes by content. `needed`:
// by node.
nlohmann::json given_values_json(const Graph&, const std::vector<bool>& needed);
// Gives the values of such JSON again. It may come from a stranger. Throws Error "damaged".
GivenValues give_values(const nlohmann::json&, const ValueTypes&);
// Throws Error "given-array" if a node of the graph gives a value that is not available. `file`: what it was
// made for.
void require_given_values(const Graph&, const std::string& file);

}  // namespace terrazzo
