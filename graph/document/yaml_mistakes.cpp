#include "graph/document/yaml_mistakes.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace terrazzo {
namespace {

// Where a line begins, from 1, or the end of the text.
std::size_t begin_of(const std::string& text, int line) {
  std::size_t at = 0;
  for (int k = 1; k < line && at < text.size(); ++k) at = std::min(text.find('\n', at), text.size() - 1) + 1;
  return at;
}

bool contains(std::string_view set, char c) { return set.find(c) != std::string_view::npos; }

// The "#c0b8a8" of a line where a value is expected, or "".
std::string_view color_of(std::string_view line) {
  for (std::size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1)) {
    const auto before = line.substr(0, at).find_last_not_of(" \t");
    if (before == std::string_view::npos || !contains(":,[{-", line[before])) continue;
    const auto end = std::min(line.find_first_not_of("0123456789abcdefABCDEF", at + 1), line.size());
    const auto behind = line.find_first_not_of(" \t\r", end);
    const std::size_t digits = end - at - 1;
    if ((digits == 3 || digits == 6) && (behind == std::string_view::npos || contains(",]}", line[behind])))
      return line.substr(at, digits + 1);
  }
  return {};
}

}  // namespace

std::optional<YamlMistake> commented_color(const std::string& text, int first, int last) {
  std::size_t begin = begin_of(text, first);
  for (int line = first; line <= last && begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (const auto color = color_of(std::string_view(text).substr(begin, end - begin)); !color.empty())
      return YamlMistake{fmt::format("YAML reads '{}' as a comment", color),
                         fmt::format("put it in quotes: \"{}\"", color),
                         static_cast<std::size_t>(color.data() - text.data())};
    begin = end + 1;
  }
  return {};
}

std::optional<YamlMistake> yaml_mistake(const std::string& text, int line) {
  const std::size_t begin = begin_of(text, line);
  const std::size_t end = std::min(text.find_first_not_of(" \t", begin), text.size());
  if (const auto tab = text.find('\t', begin); tab < end)
    return YamlMistake{"a tab indents this line, which YAML does not allow", "indent with spaces", tab};
  return commented_color(text, 1, line);
}

}  // namespace terrazzo
