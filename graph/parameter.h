// Parameters: declarations, values, and parsing of written values.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace terrazzo {

// The value of a parameter. Colors are three scene-linear numbers. Keywords are strings.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<std::int64_t>,
                                    std::vector<double>, std::vector<std::string>>;

enum class ParameterKind {
  Bool,
  Int,
  Number,
  Choice,      // one of `choices`
  Text,        // free text
  Ints,        // one or more; a single value is a list of one
  Numbers,     // one or more
  Texts,       // one or more
  Color,       // "#rrggbb" (sRGB) or three scene-linear numbers
  InputPath,   // file to read, or a glob; the action key contains its content, not its name
  OutputPath,  // file to write, relative to the output folder
};
const char* name_of(ParameterKind);

// A value as written, without YAML syntax: a scalar or a list of scalars.
struct WrittenValue {
  bool is_list = false;
  std::vector<std::string> items;  // exactly one if !is_list
  // Line and column of each item of a list, from 1; empty if it was not read from a file.
  std::vector<std::pair<int, int>> places = {};
  std::string text() const;
};

// The declaration of a parameter. Schema, action keys, help and reference pages are derived from it.
struct Parameter {
  std::string name;
  ParameterKind kind = ParameterKind::Number;
  std::string doc;
  std::string unit;                     // "mm", "mm²", "degrees", "pixels"; "" if dimensionless
  std::optional<ParameterValue> value;  // the default; none: the parameter is required
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false;                            // min itself is not allowed
  std::vector<std::string> choices;                 // allowed values of Choice and, unless empty, of Texts
  std::vector<std::string> keywords;                // words accepted in place of a value, such as "auto"
  std::size_t min_count = 1, max_count = 1u << 20;  // allowed lengths of lists
  std::vector<std::string> former_names;            // still accepted in graph files, with a note
  // Former words of choices and keywords with their present ones; accepted like former names.
  std::vector<std::pair<std::string, std::string>> former_words;

  // Defined once, in parameter.cpp, since every node declares parameters and would compile them again.
  Parameter();
  Parameter(const Parameter&);
  Parameter(Parameter&&) noexcept;
  Parameter& operator=(const Parameter&);
  Parameter& operator=(Parameter&&) noexcept;
  ~Parameter();

  // Declares in one expression: Parameter::number("min_area", 20).unit_("pixels").range(0, 1e9).doc_("…")
  static Parameter boolean(std::string name, bool value);
  static Parameter integer(std::string name, std::int64_t value);
  static Parameter number(std::string name, double value);
  static Parameter choice(std::string name, std::string value, std::vector<std::string> choices);
  static Parameter text(std::string name, std::string value);
  static Parameter ints(std::string name, std::vector<std::int64_t> value);
  static Parameter numbers(std::string name, std::vector<double> value);
  static Parameter texts(std::string name, std::vector<std::string> value);
  static Parameter color(std::string name, double r, double g, double b);
  static Parameter input_path(std::string name);   // required
  static Parameter output_path(std::string name);  // required
  // Any kind, with a keyword as the default: with_keyword(ParameterKind::Int, "clusters", "auto")
  static Parameter with_keyword(ParameterKind kind, std::string name, std::string keyword);
  // A whole number or a keyword such as "auto", which is the default.
  static Parameter optional_integer(std::string name, std::string keyword);
  static Parameter optional_number(std::string name, std::string keyword);
  // A random seed: 0 to 2^53 − 1, which every reader of JSON keeps exactly. The default is 1.
  static Parameter seed(std::string name = "seed");

  Parameter& doc_(std::string text);
  Parameter& unit_(std::string text);
  Parameter& range(double lo, double hi);
  Parameter& above(double lo);                       // > lo
  Parameter& count(std::size_t lo, std::size_t hi);  // length of a list
  Parameter& keyword(std::string word);              // adds a keyword
  Parameter& required();                             // no default
  Parameter& was(std::string former_name);
  Parameter& word_was(std::string former, std::string word);  // of a choice or keyword
};

// Parses and checks a written value. On failure, returns nothing and explains the error in `why`, with the
// nearest valid word.
std::optional<ParameterValue> read_parameter(const Parameter&, const WrittenValue&, std::string& why);

// The unique spelling of a value that action keys contain. So writing out a default, or 1 instead of 1.0,
// does not change a key.
std::string canonical(const ParameterValue&);
// The value as a person would write it in a graph file.
std::string written(const ParameterValue&);
// The nearest sRGB color to a scene-linear one, as "#rrggbb".
std::string color_text(const std::array<double, 3>& linear);

}  // namespace terrazzo
