// What people write in YAML that means something else, or nothing.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace terrazzo {

struct YamlMistake {
  std::string message, hint;
  std::size_t at;  // byte
};

// Why a text is not YAML, if its parser fails in `line` (from 1): a tab in the indentation of that line, or a
// color in a line up to there that YAML takes for a comment.
std::optional<YamlMistake> yaml_mistake(const std::string& text, int line);

// A color in the lines `first` to `last` that YAML takes for a comment, such as in "color: #c0b8a8".
std::optional<YamlMistake> commented_color(const std::string& text, int first, int last);

}  // namespace terrazzo
