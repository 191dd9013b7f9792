// Numbers in text. The locale of the host program does not matter, unlike for std::stod, strtod and streams.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <vector>

namespace terrazzo {

// The whole text as a number: "0.5", "+3", "1e-3", "inf", "nan".
std::optional<double> read_number(std::string_view text);
// The number at the beginning of the text, after spaces, and removes both from it.
std::optional<double> take_number(std::string_view& text);
// Numbers separated by spaces, commas or both.
std::optional<std::vector<double>> read_numbers(std::string_view text);

// The number that the whole text is, or nothing.
template <class Number>
std::optional<Number> number_in_text(std::string_view text) {
  Number out{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  return out;
}

// Takes the number at the beginning of a text, after spaces, off the text. Nothing if there is none.
template <class Number>
std::optional<Number> take_number(std::string_view& text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  Number out{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error != std::errc()) return {};
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return out;
}

}  // namespace terrazzo
