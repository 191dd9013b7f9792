#include "graph/text/element_name.h"

#include <algorithm>

#include "graph/text/utf8.h"

namespace terrazzo {
namespace {

constexpr std::size_t kLongestWord = 64;  // bytes

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

bool names_element(const std::string& s) {
  return !s.empty() && s.size() <= kLongestWord && std::all_of(s.begin(), s.end(), [](char c) {
    return is_letter_or_digit(c) || (c & 0x80) || std::string("_-+.").find(c) != std::string::npos;
  });
}

}  // namespace

std::string element_name(const std::string& node, const std::vector<ElementValue>& values) {
  std::string inside;
  for (const auto& v : values)
    inside +=
        (inside.empty() ? "" : ",") + (names_element(v.text) ? v.text : "#" + std::to_string(v.position));
  return node + "[" + inside + "]";
}

bool is_variable_name(const std::string& s) {
  return !s.empty() && !(s[0] >= '0' && s[0] <= '9') &&
         std::all_of(s.begin(), s.end(), [](char c) { return is_letter_or_digit(c) || c == '_'; });
}

std::string without_elements(const std::string& path) {
  std::string out;
  int depth = 0;
  for (const char c : path) {
    depth += c == '[';
    if (depth == 0) out += c;
    if (c == ']' && depth > 0) --depth;
  }
  return depth == 0 ? out : path;
}

bool is_named(const std::string& path, const std::string& name) {
  return path == name ||
         (path.size() > name.size() && path.find('[') != std::string::npos && without_elements(path) == name);
}

std::size_t find_port_dot(const std::string& reference) {
  const auto bracket = reference.rfind(']');
  const auto dot = reference.rfind('.');
  return bracket == std::string::npos || dot == std::string::npos || dot > bracket ? dot : std::string::npos;
}

std::string written_node(const std::string& reference) {
  return reference.substr(0, std::min(reference.find('['), find_port_dot(reference)));
}

bool is_node_name(const std::string& name) {
  return !name.empty() && name.find(' ') == std::string::npos && escape_line(name) == name &&
         find_port_dot(name) == std::string::npos && without_elements(name).find('.') == std::string::npos;
}

}  // namespace terrazzo
