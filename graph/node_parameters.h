// NodeParameters: the parameters of one node with defaults filled in, as compute functions and checks read
// them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/parameter.h"

namespace terrazzo {

struct NodeType;

// Every value has been checked against its declaration. Reading an undeclared parameter, or one as the wrong
// kind, throws Error "node-bug".
class NodeParameters {
 public:
  bool boolean(const std::string& name) const;
  std::int64_t integer(const std::string& name) const;
  double number(const std::string& name) const;
  std::string text(const std::string& name) const;  // Text, Choice, OutputPath
  std::vector<std::int64_t> ints(const std::string& name) const;
  std::vector<double> numbers(const std::string& name) const;  // Numbers, Color
  std::vector<std::string> texts(const std::string& name) const;
  // The keyword used in place of a value, such as "auto", or "" if there is a value.
  std::string keyword(const std::string& name) const;
  // No value if a keyword is used in its place.
  std::optional<std::int64_t> optional_integer(const std::string& name) const;
  std::optional<double> optional_number(const std::string& name) const;
  // A Choice as an enum whose values are 0, 1, … in the order of the declared choices.
  template <class Enum>
  Enum choice(const std::string& name) const {
    return static_cast<Enum>(choice_index(name));
  }
  std::uint64_t seed(const std::string& name = "seed") const {
    return static_cast<std::uint64_t>(integer(name));
  }

 protected:
  NodeParameters() = default;
  NodeParameters(const NodeType& type, std::map<std::string, ParameterValue> set);

  const NodeType* type_ = nullptr;
  std::map<std::string, ParameterValue> parameters_;

 private:
  friend class Linker;
  const ParameterValue& raw(const std::string& name) const;
  int choice_index(const std::string& name) const;
};

}  // namespace terrazzo
