// The node types of a program, by name.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "graph/node_type.h"

namespace terrazzo {

class Registry {
 public:
  // Throws Error "duplicate-node-type" if the name is taken, "bad-node-type" if the declaration is incomplete
  // or invalid.
  void add(NodeType);
  // Like add(), but replaces a type of the same name. Graphs keep the type that they were linked with.
  void replace(NodeType);
  const NodeType* find(const std::string& name) const;
  // The type that had this name in an earlier version, or null.
  const NodeType* find_former(const std::string& name) const;
  std::vector<const NodeType*> all() const;  // sorted by name
  std::vector<std::string> names() const;
  struct District {
    std::string name;
    std::vector<const NodeType*> types;  // sorted by name
  };
  // All node types by district, in the order in which the districts were first added; types without a
  // district are last, as "other".
  std::vector<District> by_district() const;

 private:
  std::map<std::string, std::unique_ptr<NodeType>> types_;
  std::vector<std::string> districts_;
  std::vector<std::unique_ptr<NodeType>> replaced_;  // graphs may still refer to them
};

}  // namespace terrazzo
