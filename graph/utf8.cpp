#include "graph/utf8.h"

namespace terrazzo {

std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xc2 && first < 0xe0   ? 2
                             : (first & 0xf0) == 0xe0        ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  const bool overlong = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xf0 && byte(1) < 0x90);
  const bool surrogate = first == 0xed && byte(1) >= 0xa0, beyond = first == 0xf4 && byte(1) >= 0x90;
  return overlong || surrogate || beyond ? 0 : length;
}

std::size_t find_invalid_utf8(std::string_view text, std::size_t from) {
  while (from < text.size()) {
    const std::size_t n = utf8_length(text.substr(from));
    if (n == 0) return from;
    from += n;
  }
  return std::string_view::npos;
}

std::string valid_utf8(std::string text) {
  std::size_t bad = find_invalid_utf8(text);
  if (bad == std::string::npos) return text;
  std::string out;
  std::size_t from = 0;
  for (; bad != std::string::npos; from = bad + 1, bad = find_invalid_utf8(text, from))
    out.append(text, from, bad - from).append("\xef\xbf\xbd");
  return out.append(text, from);
}

}  // namespace terrazzo
