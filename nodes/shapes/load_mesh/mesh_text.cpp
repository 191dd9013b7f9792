#include "nodes/shapes/load_mesh/mesh_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "nodes/common/io/reading.h"

namespace terrazzo::load_mesh {

void damaged(const std::string& what) {
  throw Error("unreadable-mesh", what, "the file is damaged: export it again");
}

void require_corners(std::size_t f, std::size_t corners) {
  if (corners < 3)
    throw Error("bad-mesh", fmt::format("face {} has {} corners", f, corners),
                "remove lines and points from the mesh");
}

std::string lowercase(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = c - 'A' + 'a';
  return out;
}

Words::Words(std::string_view text) : rest_(text) {
  const auto end = text.find_first_of("\r\n");
  if (end != std::string_view::npos && text[end] == '\r' && text.substr(end + 1, 1) != "\n") line_end_ = '\r';
}

bool Words::next_line(char comment) {
  if (rest_.empty()) return false;
  const auto end = rest_.find(line_end_);
  line_ = rest_.substr(0, end);
  rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
  if (comment != '\0') line_ = line_.substr(0, line_.find(comment));
  ++number_;
  return true;
}

std::string_view Words::word() {
  constexpr std::string_view kBlanks = " \t\r\n\v\f";
  const auto first = line_.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return line_ = {};
  const auto length = line_.substr(first).find_first_of(kBlanks);
  const auto found = line_.substr(first, length);
  line_ = length == std::string_view::npos ? std::string_view() : line_.substr(first + length);
  return found;
}

std::string_view Words::word_anywhere(char comment) {
  while (true) {
    if (const auto found = word(); !found.empty()) return found;
    if (!next_line(comment)) damaged("the file ends before all elements that its header lists");
  }
}

std::optional<double> number_in(std::string_view word) {
  const std::string_view digits = word.substr(word.starts_with('+') ? 1 : 0);
  double v = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), v);
  const bool whole = end == digits.data() + digits.size() && !digits.empty();
  if (error == std::errc::result_out_of_range && whole &&
      digits.find_first_of("eE") != std::string_view::npos && digits[digits.find_first_of("eE") + 1] == '-')
    return 0.0;  // underflow
  if (error != std::errc() || !whole || !(std::abs(v) <= std::numeric_limits<float>::max()))
    return std::nullopt;
  return v;
}

double coordinate(std::string_view word, int line) {
  const std::optional<double> v = number_in(word);
  if (!v) damaged(fmt::format("line {}: \"{}\" is not a number", line, printable(word)));
  return *v;
}

std::uint64_t count(std::string_view word, std::uint64_t most, int line, const char* what) {
  std::uint64_t n = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), n);
  if (error != std::errc() || end != word.data() + word.size() || n > most)
    damaged(fmt::format("line {}: {} cannot be \"{}\"", line, what, printable(word)));
  return n;
}

}  // namespace terrazzo::load_mesh
