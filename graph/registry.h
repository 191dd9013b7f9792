// The node types that a program knows, by name.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "graph/node_type.h"

namespace terrazzo {

class Registry {
 public:
  // Throws Error "duplicate-node-type" when the name is taken, "bad-node-type" when the declaration is not
  // whole.
  void add(NodeType);
  const NodeType* find(const std::string& name) const;
  // The type that once had this name, or null.
  const NodeType* find_former(const std::string& name) const;
  std::vector<const NodeType*> all() const;  // by name
  std::vector<std::string> names() const;

 private:
  std::map<std::string, NodeType> types_;
};

}  // namespace terrazzo
