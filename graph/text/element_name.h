// Names of the elements of a repeated node: "solid[17]", "tables[photo,small]". Inside a subgraph,
// "part[3]/pack".
#pragma once

#include <string>
#include <vector>

namespace terrazzo {

// Values that are words or numbers, such as "photo" or "0.35", name the element. Any other value is replaced
// by # and its position, counted from 0: "stone[#2]". A word has at most 64 bytes, all of them letters,
// digits, _ - + . or beyond ASCII.
struct ElementValue {
  std::string text;
  std::size_t position = 0;
};
std::string element_name(const std::string& node, const std::vector<ElementValue>&);

// Whether the values of a repeated node may have this name: a letter or _, then letters, digits and _.
bool is_variable_name(const std::string&);

// The path with all brackets removed: "part[3]/pack" → "part/pack". The same path if it has none.
std::string without_elements(const std::string& path);

// Whether `path` is `name`, or one of the elements that `name` stands for: "part/pack" stands for
// "part[3]/pack".
bool is_named(const std::string& path, const std::string& name);

// The position of the dot in "node.port", or npos. Dots inside brackets belong to the node.
std::size_t find_port_dot(const std::string& reference);

// The node of a reference as the file names it: "solid" for "solid[17].volume".
std::string written_node(const std::string& reference);

// Whether a node may have this name: not empty, without spaces, and without dots outside brackets.
bool is_node_name(const std::string&);

}  // namespace terrazzo
