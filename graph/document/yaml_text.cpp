#include "graph/document/yaml_text.h"

#include "graph/text/utf8.h"

namespace terrazzo {
namespace {

// Whether a word can be written without quotes, also inside of {} and [].
bool is_plain(const std::string& s) {
  if (s.empty() || s == "~" || s == "null" || s == "Null" || s == "NULL") return false;
  if (s.front() == ' ' || s.back() == ' ' || s.back() == ':') return false;
  const bool dash = s[0] == '-' || s[0] == '?' || s[0] == ':';
  if (dash && (s.size() == 1 || s[1] == ' ' || s[1] == '-')) return false;
  if (s.rfind("...", 0) == 0 || s.rfind("<<", 0) == 0) return false;
  if (std::string("?:#&*!|>'\"%@`=").find(s[0]) != std::string::npos) return false;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const unsigned char c = s[i];
    // Control characters, and the first byte of those beyond ASCII, of the separators and of the byte order
    // mark, which YAML does not allow in plain words.
    if (c < 0x20 || c == 0x7f || c == 0xc2 || c == 0xef) return false;
    if (c == 0xe2 && i + 1 < s.size() && (static_cast<unsigned char>(s[i + 1]) & 0xfe) == 0x80) return false;
    if (std::string(",[]{}").find(s[i]) != std::string::npos) return false;
    if (s[i] == ':' && s[i + 1] == ' ') return false;
    if (s[i] == '#' && s[i - 1] == ' ') return false;
  }
  return true;
}

}  // namespace

std::string yaml_word(const std::string& s) {
  if (is_plain(s)) return s;
  std::string quoted = "\"";
  for (const char c : s) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n')
      quoted += "\\n";
    else if (c == '\t')
      quoted += "\\t";
    else
      quoted += c;
  }
  return escape_line(quoted) + "\"";
}

std::string yaml_list(const std::vector<std::string>& list) {
  std::string out;
  for (const auto& item : list) out += (out.empty() ? "" : ", ") + yaml_word(item);
  return "[" + out + "]";
}

std::string yaml_value(const WrittenValue& v) { return v.is_list ? yaml_list(v.items) : yaml_word(v.text()); }

}  // namespace terrazzo
