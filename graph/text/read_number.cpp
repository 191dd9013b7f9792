#include "graph/text/read_number.h"

#include <algorithm>
#include <charconv>

namespace terrazzo {
namespace {

void skip(std::string_view& text, std::string_view characters) {
  text.remove_prefix(std::min(text.find_first_not_of(characters), text.size()));
}

}  // namespace

std::optional<double> take_number(std::string_view& text) {
  std::string_view rest = text;
  skip(rest, " \t\r\n");
  if (rest.size() > 1 && rest[0] == '+' && rest[1] != '-') rest.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (error != std::errc()) return {};
  text = rest.substr(end - rest.data());
  return value;
}

std::optional<double> read_number(std::string_view text) {
  if (!text.empty() && std::string_view(" \t\r\n").find(text[0]) != std::string_view::npos) return {};
  const auto value = take_number(text);
  return text.empty() ? value : std::nullopt;
}

std::optional<std::vector<double>> read_numbers(std::string_view text) {
  constexpr std::string_view kBetween = " \t\r\n,";
  std::vector<double> out;
  for (skip(text, kBetween); !text.empty(); skip(text, kBetween)) {
    const auto value = take_number(text);
    if (!value || (!text.empty() && kBetween.find(text[0]) == std::string_view::npos)) return {};
    out.push_back(*value);
  }
  return out;
}

}  // namespace terrazzo
