// Parameters: their declaration, their values, and how a written value becomes one.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace terrazzo {

// What a parameter holds once read. Colours are three scene-linear numbers; a keyword is a string.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<std::int64_t>,
                                    std::vector<double>, std::vector<std::string>>;

enum class ParameterKind {
  Bool,
  Int,
  Number,
  Choice,      // one of `choices`
  Text,        // free text
  Ints,        // one or several; a single value is a list of one
  Numbers,     // one or several
  Texts,       // one or several
  Color,       // "#rrggbb" (sRGB) or three scene-linear numbers
  InputPath,   // a file that is read: its content enters the key, not its name; may be a glob
  OutputPath,  // a file that is written, relative to the output folder
};
const char* name_of(ParameterKind);

// The written form of a value, free of any syntax: a scalar or a list of scalars.
struct WrittenValue {
  bool is_list = false;
  std::vector<std::string> items;  // exactly one where !is_list
  std::string text() const;
};

// The declaration of a parameter: from it come schema, key, help and reference pages.
struct Parameter {
  std::string name;
  ParameterKind kind = ParameterKind::Number;
  std::string doc;
  std::string unit;                     // "mm", "mm²", "degrees", "pixels"; "" for a pure number
  std::optional<ParameterValue> value;  // the default; without one the user must write it
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false;              // min itself is not allowed
  std::vector<std::string> choices;   // of a Choice
  std::vector<std::string> keywords;  // words allowed beside the kind's own values, such as "auto"
  std::size_t min_count = 1, max_count = 1u << 20;  // of lists
  std::vector<std::string> former_names;            // still read in graph files, with a note

  // Declaration in one expression: Parameter::number("min_area", 20).unit_("pixels").range(0, 1e9).doc_("…")
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
  // The same kinds with a keyword as the default: with_keyword(ParameterKind::Int, "clusters", "auto")
  static Parameter with_keyword(ParameterKind kind, std::string name, std::string keyword);

  Parameter& doc_(std::string text);
  Parameter& unit_(std::string text);
  Parameter& range(double lo, double hi);
  Parameter& above(double lo);                       // > lo
  Parameter& count(std::size_t lo, std::size_t hi);  // length of a list
  Parameter& keyword(std::string word);              // one more allowed word
  Parameter& required();                             // no default
  Parameter& was(std::string former_name);
};

// Reads a written value. Returns the value, or says what is wrong in `why` (with the nearest valid word).
std::optional<ParameterValue> read_parameter(const Parameter&, const WrittenValue&, std::string& why);

// One spelling per value: enters keys, so a default written out or 1 for 1.0 changes nothing.
std::string canonical(const ParameterValue&);
// As a person would write it in a graph file.
std::string written(const ParameterValue&);

}  // namespace terrazzo
