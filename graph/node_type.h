// A node type. The JSON Schema, action keys, reference pages and help are all derived from this declaration.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "graph/parameter.h"

namespace terrazzo {

class Context;         // runtime/context.h
class NodeParameters;  // graph/node_parameters.h

struct Port {
  std::string name;
  std::vector<std::string> types;  // names of value types; an input without types accepts any
  std::string doc;
  bool optional = false;
  bool many = false;                           // the input accepts a list of wires
  bool one_at_a_time = false;                  // of a list: the node takes its values with Context::nth()
  std::vector<std::string> former_names = {};  // still accepted in graph files, with a note
  bool accepts(const std::string& type) const;
  std::string type_text() const;  // "Image", "Particles or Volume", "any"
};

struct NodeType {
  std::string name;
  int version = 1;  // raise it whenever the same inputs can produce a different result
  std::string doc;
  std::string source;  // source paper and section, or ""
  std::vector<Port> inputs;
  std::vector<Port> outputs;
  std::vector<Parameter> parameters;
  std::vector<std::string> former_names;  // still accepted in graph files, with a note
  bool writes_files = false;              // its results are files in the output folder
  // Other files that the node opens along with an input file, such as the .img of a .hdr. Their content is
  // part of the action key, like that of the file itself. Null if the node opens only the files named by its
  // parameters.
  std::vector<std::filesystem::path> (*companion_files)(const std::filesystem::path&) = nullptr;
  // Checks rules across several parameters, such as low ≤ high. Runs with every graph that is loaded, before
  // any work. Throws Error, which names a parameter. Null if there are none.
  void (*check)(const NodeParameters&) = nullptr;
  void (*compute)(Context&) = nullptr;
  // What the node is about, such as "sizes": the folder below nodes/ that contains it. "" in plugins.
  std::string district;

  NodeType(std::string name, int version);
  // Defined once, in node_type.cpp, since every node returns one and would compile them again.
  NodeType(const NodeType&);
  NodeType(NodeType&&) noexcept;
  NodeType& operator=(const NodeType&);
  NodeType& operator=(NodeType&&) noexcept;
  ~NodeType();
  NodeType& doc_(std::string text);
  NodeType& source_(std::string text);
  NodeType& input(std::string name, std::string type, std::string doc);
  NodeType& optional_input(std::string name, std::vector<std::string> types, std::string doc);
  NodeType& input_list(std::string name, std::vector<std::string> types, std::string doc);
  NodeType& one_at_a_time();  // of the input declared last, a list: its values need not be in memory together
  NodeType& output(std::string name, std::string type, std::string doc);
  NodeType& parameter(Parameter);
  NodeType& was(std::string former_name);
  NodeType& input_was(std::string former_name);   // of the input declared last
  NodeType& output_was(std::string former_name);  // of the output declared last
  NodeType& writes_files_();
  NodeType& companion_files_(std::vector<std::filesystem::path> (*fn)(const std::filesystem::path&));
  NodeType& check_(void (*fn)(const NodeParameters&));
  NodeType& compute_(void (*fn)(Context&));
  NodeType& in_district(std::string name);

  const Port* find_input(const std::string&) const;
  const Port* find_output(const std::string&) const;
  // The port that had this name in an earlier version, or null.
  const Port* find_former_input(const std::string&) const;
  const Port* find_former_output(const std::string&) const;
  const Parameter* find_parameter(const std::string&) const;  // by its current name
};

}  // namespace terrazzo
