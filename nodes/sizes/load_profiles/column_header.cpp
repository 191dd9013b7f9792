#include "nodes/sizes/load_profiles/column_header.h"

#include <algorithm>
#include <map>
#include <vector>

namespace terrazzo::load_profiles {
namespace {

bool is_letter_or_digit(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }

void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
}

// Small letters, with one spelling of signs that programs write in several ways.
std::string simplified(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = c - 'A' + 'a';
  static constexpr std::pair<std::string_view, std::string_view> kSigns[] = {
      {"µ", "u"},        {"μ", "u"},        {"Μ", "u"}, {"²", "2"},     {"³", "3"},
      {"Å", "angstrom"}, {"å", "angstrom"}, {"×", "x"}, {"\u00a0", " "}};
  for (const auto& [sign, by] : kSigns) replace_all(out, sign, by);
  return out;
}

double length_of(const std::string& word) {
  static const std::map<std::string, double> mm = {
      {"nm", 1e-6},      {"nanometer", 1e-6},  {"nanometre", 1e-6},  {"um", 1e-3},       {"micron", 1e-3},
      {"mum", 1e-3},     {"micrometer", 1e-3}, {"micrometre", 1e-3}, {"mm", 1},          {"millimeter", 1},
      {"millimetre", 1}, {"cm", 10},           {"centimeter", 10},   {"centimetre", 10}, {"dm", 100},
      {"km", 1e6},       {"mil", 0.0254},      {"ft", 304.8},        {"m", 1000},        {"meter", 1000},
      {"metre", 1000},   {"inch", 25.4},       {"inche", 25.4},      {"in", 25.4},       {"angstrom", 1e-7},
      {"px", 0},         {"pix", 0},           {"pixel", 0}};
  const auto found = mm.find(word);
  return found == mm.end() ? -1 : found->second;
}

// The words and numbers of a text, without what separates them.
std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> out(1);
  for (const char c : text) {
    if (is_letter_or_digit(c))
      out.back() += c;
    else if (!out.back().empty())
      out.emplace_back();
  }
  if (out.back().empty()) out.pop_back();
  return out;
}

// Of simplified text.
std::optional<Unit> simplified_unit(std::string text) {
  int power = 0;
  const auto mark = [&](std::string_view what, int value) {
    const auto at = text.find(what);
    if (at == std::string::npos) return;
    text.erase(at, what.size());
    power = value;
  };
  for (const std::string_view word : {"squared", "square", "sq."}) mark(word, 2);
  mark("cubic", 3);
  std::string dense;
  for (const char c : text)
    if (std::string_view(" \t^*{}_.").find(c) == std::string_view::npos) dense += c;
  if (dense.starts_with("sq")) {
    dense.erase(0, 2);
    power = 2;
  }
  if (!dense.empty() && dense.back() >= '1' && dense.back() <= '3') {
    power = dense.back() - '0';
    dense.pop_back();
  }
  double mm = length_of(dense);
  if (mm < 0 && dense.size() > 3 && dense.ends_with('s')) mm = length_of(dense.substr(0, dense.size() - 1));
  const std::size_t half = dense.size() / 2;  // "um x um", "mm*mm"
  if (mm < 0 && dense.size() > 2 && power == 0) {
    const bool cross = dense.size() % 2 == 1 && dense[half] == 'x';
    if (dense.substr(0, half) == dense.substr(half + (cross ? 1 : 0))) {
      mm = length_of(dense.substr(0, half));
      power = 2;
    }
  }
  if (mm < 0) return std::nullopt;
  return Unit{mm, power};
}

// Whether text in brackets that is no known unit may stand for one: it is a percentage, has a character that
// was lost, ends with a power, or contains a unit among other things, as in "10³ µm²".
bool looks_like_unit(const std::string& text) {
  const std::size_t n = text.size();
  if (n > 1 && (text[n - 1] == '2' || text[n - 1] == '3') &&
      (text[n - 2] == '^' || (text[n - 2] >= 'a' && text[n - 2] <= 'z')))
    return true;
  if (text.find_first_of("%?") != std::string::npos || text.find("\uFFFD") != std::string::npos) return true;
  for (const std::string& word : words_of(text))
    if (const auto unit = simplified_unit(word); unit && !(unit->power == 0 && (word == "m" || word == "in")))
      return true;
  return false;
}

}  // namespace

std::string plain_name(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c >= 'A' && c <= 'Z') out += static_cast<char>(c - 'A' + 'a');
    if (is_letter_or_digit(c) || c == '%') out += c;
  }
  return out;
}

std::optional<Unit> unit_of(std::string_view text) { return simplified_unit(simplified(text)); }

ColumnHeader read_header(const std::string& header) {
  ColumnHeader out;
  const std::string text = simplified(header);
  if (const auto open = text.find_first_of("([{"); open != std::string::npos && open > 0) {
    out.name = plain_name(std::string_view(text).substr(0, open));
    // The text of each pair of brackets; the last one that is a unit counts.
    for (auto from = open; from != std::string::npos; from = text.find_first_of("([{", from + 1)) {
      const auto close = std::min(text.find_first_of(")]}", from), text.size());
      const std::string inner = text.substr(from + 1, close - from - 1);
      const auto unit = simplified_unit(inner);
      if (!unit && (out.unit || !looks_like_unit(inner))) continue;
      out.unit = unit;
      out.unit_text = inner;
    }
    return out;
  }
  out.name = plain_name(text);
  // Without brackets, the unit is what follows a separator at the end.
  for (auto at = text.find_first_of(" _./,:-"); at != std::string::npos;
       at = text.find_first_of(" _./,:-", at + 1)) {
    std::string name = text.substr(0, at);
    const auto unit = simplified_unit(text.substr(at + 1));
    if (!unit || plain_name(name).empty()) continue;
    if (name.ends_with(" in")) name.resize(name.size() - 3);
    out = {plain_name(name), text.substr(at + 1), unit};
    break;
  }
  return out;
}

}  // namespace terrazzo::load_profiles
