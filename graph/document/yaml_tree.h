// The tree of a YAML text, with the bytes that each value occupies.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace terrazzo {

struct YamlEntry;

struct YamlNode {
  enum class Kind { Scalar, Map, List, Alias };
  Kind kind = Kind::Scalar;
  bool flow = false;               // a map or list in braces or brackets
  std::size_t begin = 0;           // first byte, behind an anchor and a tag
  std::size_t end = 0;             // behind the last byte, without comments that follow
  std::string text;                // of a scalar
  std::vector<YamlEntry> entries;  // of a map
  std::vector<YamlNode> items;     // of a list
};

struct YamlEntry {
  YamlNode first, second;  // key and value
};

// Nothing if the text is not one YAML document, or if it is nested deeper than any graph.
std::optional<YamlNode> read_yaml_tree(const std::string& text);

}  // namespace terrazzo
