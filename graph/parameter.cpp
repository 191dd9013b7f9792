#include "graph/parameter.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "graph/output_path.h"
#include "graph/text/nearest.h"
#include "graph/text/utf8.h"

namespace terrazzo {

const char* name_of(ParameterKind k) {
  switch (k) {
    case ParameterKind::Bool:
      return "bool";
    case ParameterKind::Int:
      return "int";
    case ParameterKind::Number:
      return "number";
    case ParameterKind::Choice:
      return "choice";
    case ParameterKind::Text:
      return "text";
    case ParameterKind::Ints:
      return "ints";
    case ParameterKind::Numbers:
      return "numbers";
    case ParameterKind::Texts:
      return "texts";
    case ParameterKind::Color:
      return "color";
    case ParameterKind::InputPath:
      return "path";
    case ParameterKind::OutputPath:
      return "output path";
  }
  return "?";
}

Parameter::Parameter() = default;
Parameter::Parameter(const Parameter&) = default;
Parameter::Parameter(Parameter&&) noexcept = default;
Parameter& Parameter::operator=(const Parameter&) = default;
Parameter& Parameter::operator=(Parameter&&) noexcept = default;
Parameter::~Parameter() = default;

std::string WrittenValue::text() const {
  if (!is_list) return items.empty() ? "" : items[0];
  return fmt::format("[{}]", fmt::join(items, ", "));
}

namespace {
Parameter make(ParameterKind kind, std::string name, std::optional<ParameterValue> value) {
  Parameter p;
  p.name = std::move(name);
  p.kind = kind;
  p.value = std::move(value);
  return p;
}
}  // namespace

Parameter Parameter::boolean(std::string n, bool v) { return make(ParameterKind::Bool, std::move(n), v); }
Parameter Parameter::integer(std::string n, std::int64_t v) {
  return make(ParameterKind::Int, std::move(n), v);
}
Parameter Parameter::number(std::string n, double v) { return make(ParameterKind::Number, std::move(n), v); }
Parameter Parameter::choice(std::string n, std::string v, std::vector<std::string> choices) {
  Parameter p = make(ParameterKind::Choice, std::move(n), std::move(v));
  p.choices = std::move(choices);
  return p;
}
Parameter Parameter::text(std::string n, std::string v) {
  return make(ParameterKind::Text, std::move(n), std::move(v));
}
Parameter Parameter::ints(std::string n, std::vector<std::int64_t> v) {
  return make(ParameterKind::Ints, std::move(n), std::move(v));
}
Parameter Parameter::numbers(std::string n, std::vector<double> v) {
  return make(ParameterKind::Numbers, std::move(n), std::move(v));
}
Parameter Parameter::texts(std::string n, std::vector<std::string> v) {
  return make(ParameterKind::Texts, std::move(n), std::move(v));
}
Parameter Parameter::color(std::string n, double r, double g, double b) {
  return make(ParameterKind::Color, std::move(n), std::vector<double>{r, g, b});
}
Parameter Parameter::input_path(std::string n) { return make(ParameterKind::InputPath, std::move(n), {}); }
Parameter Parameter::output_path(std::string n) { return make(ParameterKind::OutputPath, std::move(n), {}); }
Parameter Parameter::with_keyword(ParameterKind kind, std::string n, std::string keyword) {
  Parameter p = make(kind, std::move(n), keyword);
  p.keywords.push_back(std::move(keyword));
  return p;
}

Parameter Parameter::optional_integer(std::string n, std::string keyword) {
  return with_keyword(ParameterKind::Int, std::move(n), std::move(keyword));
}
Parameter Parameter::optional_number(std::string n, std::string keyword) {
  return with_keyword(ParameterKind::Number, std::move(n), std::move(keyword));
}
Parameter Parameter::seed(std::string n) {
  return integer(std::move(n), 1).range(0, 9007199254740991).doc_("Random seed");
}

Parameter& Parameter::doc_(std::string t) {
  doc = std::move(t);
  return *this;
}
Parameter& Parameter::unit_(std::string t) {
  unit = std::move(t);
  return *this;
}
Parameter& Parameter::range(double lo, double hi) {
  min = lo;
  max = hi;
  return *this;
}
Parameter& Parameter::above(double lo) {
  min = lo;
  min_open = true;
  return *this;
}
Parameter& Parameter::count(std::size_t lo, std::size_t hi) {
  min_count = lo;
  max_count = hi;
  return *this;
}
Parameter& Parameter::keyword(std::string w) { return keywords.push_back(std::move(w)), *this; }
Parameter& Parameter::required() { return value.reset(), *this; }
Parameter& Parameter::was(std::string former) { return former_names.push_back(std::move(former)), *this; }
Parameter& Parameter::word_was(std::string former, std::string word) {
  return former_words.emplace_back(std::move(former), std::move(word)), *this;
}

namespace {

template <class T>
std::optional<T> parse_number(const std::string& s) {
  T v{};
  const char* first = s.data() + (s.size() > 1 && s[0] == '+');
  const auto [end, error] = std::from_chars(first, s.data() + s.size(), v);
  if (error != std::errc() || end != s.data() + s.size()) return {};
  return v;
}

// Squares and reciprocals of smaller numbers leave the range of floats.
constexpr double kSmallest = 1e-30;
constexpr double kMostColor = 1e6;  // of a color's component; 1 is white

bool too_small(double v) { return v != 0 && std::abs(v) < kSmallest; }

bool in_range(const Parameter& p, double v, std::string& why) {
  if (!std::isfinite(v)) {
    why = fmt::format("{} is not a finite number", v);
    return false;
  }
  if (too_small(v)) {
    why = fmt::format("{} is too close to 0: write 0, or at least {} in magnitude", v, kSmallest);
    return false;
  }
  if (v > p.min || (v == p.min && !p.min_open)) {
    if (v <= p.max) return true;
  }
  const std::string unit = p.unit.empty() ? "" : " " + p.unit;
  if (std::isinf(p.max))
    why = fmt::format("{} is out of range: it must be {} {}{}", v, p.min_open ? "above" : "at least", p.min,
                      unit);
  else if (std::isinf(p.min))
    why = fmt::format("{} is out of range: it must be at most {}{}", v, p.max, unit);
  else
    why = fmt::format("{} is out of range: it must be {} {} and {}{}{}", v, p.min_open ? "above" : "between",
                      p.min, p.min_open ? "at most " : "", p.max, unit);
  return false;
}

template <class T>
bool read_list(const Parameter& p, const WrittenValue& w, std::vector<T>& out, std::string& why) {
  if (w.items.size() < p.min_count || w.items.size() > p.max_count) {
    why = p.min_count == p.max_count
              ? fmt::format("needs {} values, not {}", p.min_count, w.items.size())
              : fmt::format("needs {} to {} values, not {}", p.min_count, p.max_count, w.items.size());
    return false;
  }
  for (const auto& item : w.items) {
    const auto v = parse_number<T>(item);
    if (!v) {
      why = fmt::format("'{}' is not {}", item, std::is_integral_v<T> ? "a whole number" : "a number");
      return false;
    }
    if (!in_range(p, static_cast<double>(*v), why)) return false;
    out.push_back(*v);
  }
  return true;
}

std::optional<ParameterValue> read_color(const WrittenValue& w, std::string& why) {
  std::vector<double> rgb;
  if (w.is_list && w.items.size() == 3) {
    for (const auto& item : w.items) {
      const auto v = parse_number<double>(item);
      if (!v || !(*v >= 0 && *v <= kMostColor) || too_small(*v)) {
        why = fmt::format("'{}' is not a valid color component: it must be a number from 0 to {}", item,
                          kMostColor);
        return std::nullopt;
      }
      rgb.push_back(*v);
    }
    return rgb;
  }
  const std::string s = w.text();
  if (!w.is_list && s.size() == 7 && s[0] == '#') {
    for (int i = 0; i < 3; ++i) {
      int byte = 0;
      const char* at = s.data() + 1 + 2 * i;
      const auto [end, error] = std::from_chars(at, at + 2, byte, 16);
      if (error != std::errc() || end != at + 2) {
        why = "'" + s + "' is not a color such as \"#a0b0c0\"";
        return std::nullopt;
      }
      const double e = byte / 255.0;  // IEC 61966-2-1
      rgb.push_back(e <= 0.04045 ? e / 12.92 : std::pow((e + 0.055) / 1.055, 2.4));
    }
    return rgb;
  }
  why = "'" + s + "' is not a color: write \"#rrggbb\" or three linear numbers";
  return std::nullopt;
}

}  // namespace

std::string color_text(const std::array<double, 3>& linear) {
  std::string out = "#";
  for (const double c : linear) {
    const double e = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;  // IEC 61966-2-1
    out += fmt::format("{:02x}", std::clamp<int>(std::lround(255 * e), 0, 255));
  }
  return out;
}

namespace {

// Adds the keywords, which would be valid too.
std::string or_keyword(const Parameter& p, const std::string& word, std::string text) {
  if (!p.keywords.empty()) text += fmt::format(", nor one of {}", fmt::join(p.keywords, ", "));
  return text + did_you_mean(word, p.keywords);
}

std::optional<ParameterValue> read_choice(const Parameter& p, const std::string& word, std::string& why) {
  if (std::find(p.choices.begin(), p.choices.end(), word) != p.choices.end()) return word;
  why =
      fmt::format("'{}' is not one of {}{}", word, fmt::join(p.choices, ", "), did_you_mean(word, p.choices));
  return std::nullopt;
}

std::optional<ParameterValue> read_path(const Parameter& p, const std::string& word, std::string& why) {
  if (word.empty()) {
    why = "the path is empty";
    return std::nullopt;
  }
  if (word.find('\0') != std::string::npos) {
    why = "the path contains a zero byte";
    return std::nullopt;
  }
  if (p.kind == ParameterKind::OutputPath && escape_line(word) != word) {
    why = "the name of an output file contains control characters";
    return std::nullopt;
  }
  if (p.kind == ParameterKind::OutputPath && leaves_folder(word)) {
    why = fmt::format(
        "'{}' is outside the output folder (use a relative path inside it; --out sets the folder)", word);
    return std::nullopt;
  }
  return word;
}

template <class T>
std::optional<ParameterValue> read_number_list(const Parameter& p, const WrittenValue& w,
                                               const std::string& word, std::string& why) {
  std::vector<T> v;
  if (read_list(p, w, v, why)) return v;
  why = or_keyword(p, word, why);
  return std::nullopt;
}

std::optional<ParameterValue> read_texts(const Parameter& p, const WrittenValue& w, std::string& why) {
  if (w.items.size() < p.min_count || w.items.size() > p.max_count) {
    why = fmt::format("needs {} to {} words, not {}", p.min_count, p.max_count, w.items.size());
    return std::nullopt;
  }
  if (!p.choices.empty())
    for (const auto& item : w.items)
      if (!read_choice(p, item, why)) return std::nullopt;
  return w.items;
}

}  // namespace

std::optional<ParameterValue> read_parameter(const Parameter& p, const WrittenValue& w, std::string& why) {
  const std::string word = w.is_list ? "" : w.text();
  if (!w.is_list && std::find(p.keywords.begin(), p.keywords.end(), word) != p.keywords.end()) return word;

  const bool wants_list = p.kind == ParameterKind::Ints || p.kind == ParameterKind::Numbers ||
                          p.kind == ParameterKind::Texts || p.kind == ParameterKind::Color;
  if (w.is_list && !wants_list) {
    why = "needs one value, not a list";
    return std::nullopt;
  }
  switch (p.kind) {
    case ParameterKind::Bool:
      if (word == "true" || word == "false") return word == "true";
      why = or_keyword(p, word, "'" + word + "' is neither true nor false");
      return std::nullopt;
    case ParameterKind::Int:
      if (const auto v = parse_number<std::int64_t>(word)) {
        if (in_range(p, *v, why)) return *v;
        return std::nullopt;
      }
      why = or_keyword(p, word, "'" + word + "' is not a whole number");
      return std::nullopt;
    case ParameterKind::Number:
      if (const auto v = parse_number<double>(word)) {
        if (in_range(p, *v, why)) return *v + 0.0;  // −0 and 0 are the same value
        return std::nullopt;
      }
      why = or_keyword(p, word, "'" + word + "' is not a number");
      return std::nullopt;
    case ParameterKind::Choice:
      return read_choice(p, word, why);
    case ParameterKind::Text:
      return word;
    case ParameterKind::InputPath:
    case ParameterKind::OutputPath:
      return read_path(p, word, why);
    case ParameterKind::Ints:
      return read_number_list<std::int64_t>(p, w, word, why);
    case ParameterKind::Numbers:
      return read_number_list<double>(p, w, word, why);
    case ParameterKind::Texts:
      return read_texts(p, w, why);
    case ParameterKind::Color: {
      const auto v = read_color(w, why);
      if (!v) why = or_keyword(p, word, why);
      return v;
    }
  }
  return std::nullopt;
}

namespace {
std::string quoted(const std::string& s) {
  std::string out = "\"";
  for (const char c : s) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}
}  // namespace

std::string canonical(const ParameterValue& v) {
  return std::visit(
      [](const auto& x) -> std::string {
        using T = std::decay_t<decltype(x)>;
        if constexpr (std::is_same_v<T, std::string>) {
          return quoted(x);
        } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
          std::string out = "[";
          for (const auto& s : x) out += quoted(s) + ",";
          return out + "]";
        } else if constexpr (std::is_same_v<T, std::vector<double>> ||
                             std::is_same_v<T, std::vector<std::int64_t>>) {
          return fmt::format("[{}]", fmt::join(x, ","));
        } else {
          return fmt::format("{}", x);
        }
      },
      v);
}

std::string written(const ParameterValue& v) {
  if (const auto* s = std::get_if<std::string>(&v)) return *s;
  if (const auto* list = std::get_if<std::vector<std::string>>(&v))
    return fmt::format("[{}]", fmt::join(*list, ", "));
  return canonical(v);
}

}  // namespace terrazzo
