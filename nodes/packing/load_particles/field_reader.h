// Collects the numbers of a JSON object's fields from the parser's events, without a document in memory.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "graph/diagnostic.h"

namespace terrazzo::load_particles {

// A field of numbers: a single number (width 0), a list (width 1), or a list of rows of `width` numbers. A
// `flat` field is a list of exactly `width` numbers.
struct Field {
  const char* name;
  int width;
  bool flat = false;
  bool required = false;
  bool found = false;
  std::vector<double> numbers = {};  // the rows of all, one after the other
};

// Receives the parser's events. Throws Error "unreadable-file" where the structure is another.
class FieldReader : public nlohmann::json_sax<nlohmann::json> {
 public:
  FieldReader(std::vector<Field>& fields, std::string file) : fields_(fields), file_(std::move(file)) {}

  bool null() override { return scalar("null"); }
  bool boolean(bool) override { return scalar("true or false"); }
  bool string(string_t&) override { return scalar("text"); }
  bool binary(binary_t&) override { return scalar("binary data"); }
  bool number_integer(number_integer_t v) override { return number(static_cast<double>(v)); }
  bool number_unsigned(number_unsigned_t v) override { return number(static_cast<double>(v)); }
  bool number_float(number_float_t v, const string_t&) override { return number(v); }
  bool start_object(std::size_t) override;
  bool end_object() override;
  bool start_array(std::size_t) override;
  bool end_array() override;
  bool key(string_t& name) override;
  bool parse_error(std::size_t at, const std::string&, const nlohmann::detail::exception& e) override;

 private:
  std::vector<Field>& fields_;
  std::string file_;
  int objects_ = 0;          // objects entered that hold fields: 1, or 2 inside `particles`
  bool enter_ = true;        // the next value may be such an object
  std::size_t ignored_ = 0;  // depth inside a value that is ignored
  Field* field_ = nullptr;   // the field whose value comes or is being read
  int lists_ = 0;            // depth inside it
  std::size_t row_ = 0;      // numbers before the current row

  bool number(double v);
  bool scalar(const char* what);
  [[noreturn]] void wrong(const std::string& what) const;
};

}  // namespace terrazzo::load_particles
