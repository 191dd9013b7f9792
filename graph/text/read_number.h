// Numbers in text. The locale of the host program does not matter, unlike for std::stod, strtod and streams.
#pragma once

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

}  // namespace terrazzo
