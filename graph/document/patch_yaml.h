// Changes one entry of nested mappings in YAML text. Every other byte stays as it is.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace terrazzo {

// The keys from the top level down to an entry: {"nodes", "pack", "params", "seed"}.
using YamlPath = std::vector<std::string>;

// Gives the entry a value on one line, such as "2" or "{a: 1}". Adds the entry, and the mappings around it,
// if they are missing. Returns nothing if the text is not YAML or has no place for the entry, for example
// behind an alias.
std::optional<std::string> set_yaml_entry(const std::string& text, const YamlPath&, const std::string& value);

// Removes the entry. Comments above it stay. Returns nothing if there is no such entry, or if removing it
// would leave a mapping in block style without entries.
std::optional<std::string> remove_yaml_entry(const std::string& text, const YamlPath&);

// Adds an entry at the end of a mapping in block style, with a value of several lines: "type: Pack\n…",
// without indentation. Falls back to set_yaml_entry() with `value` if the mapping has another style.
std::optional<std::string> add_yaml_block(const std::string& text, const YamlPath&, const std::string& block,
                                          const std::string& value);

// Adds lines, without indentation, behind the last entry of the block mapping at the path, or to one that is
// empty. Returns nothing if there is no such mapping.
std::optional<std::string> add_yaml_lines(const std::string& text, const YamlPath&, const std::string& lines);

// Adds an item at the end of the list at the path, in the list's own style. Returns nothing if there is no
// list.
std::optional<std::string> append_yaml_item(const std::string& text, const YamlPath&,
                                            const std::string& item);

// Removes an item of the list at the path. Returns nothing if there is no such item, or if it is the only
// one.
std::optional<std::string> remove_yaml_item(const std::string& text, const YamlPath&, std::size_t index);

// Renames the key of an entry.
std::optional<std::string> rename_yaml_entry(const std::string& text, const YamlPath&,
                                             const std::string& key);

}  // namespace terrazzo
