// The node types of a program, by name.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "graph/node_type.h"

namespace terrazzo {

class Registry {
 public:
  // Throws Error "duplicate-node-type" if the name is taken, "bad-node-type" if the declaration is incomplete
  // or invalid.
  void add(NodeType);
  const NodeType* find(const std::string& name) const;
  // The type that had this name in an earlier version, or null.
  const NodeType* find_former(const std::string& name) const;
  std::vector<const NodeType*> all() const;  // sorted by name
  std::vector<std::string> names() const;

 private:
  std::map<std::string, NodeType> types_;
};

}  // namespace terrazzo
