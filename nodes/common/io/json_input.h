// Values from JSON files that Export wrote, with a check of every field.
#pragma once

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/files/json_input.h"

namespace terrazzo {

class Context;

// How messages refer to a file: its name, and what to use instead of a wrong one.
struct JsonSource {
  std::string file, hint;
};

// Parses an object. If it has a field `inner` that is an object, as Export writes several inputs, returns
// that one. Throws Error "unreadable-file" if the text is not JSON.
nlohmann::json parse_json(const std::string& text, const std::string& inner, const JsonSource&);

// The text of the one file that the parameter `path` of a node names. Throws Error "several-files",
// "unreadable-file", and "too-large" if the text and what memory_to_read_json() returns exceed the node's
// memory.
std::string json_text_in(Context&);

// A JSON object whose fields are checked when they are read. All functions throw an Error with the given
// code, which names the file, the object, the field and what is wrong.
class JsonObject {
 public:
  static constexpr double kLargest = std::numeric_limits<double>::max();
  static constexpr double kSmallest = std::numeric_limits<double>::min();  // above 0

  // `what` begins messages: "profile 3: ". The references must outlive this object. Fails unless `json` is an
  // object.
  JsonObject(const nlohmann::json& json, const JsonSource& source, std::string what = "the file ",
             const char* code = "unreadable-file");

  [[noreturn]] void fail(const std::string& what) const;

  bool has(const char* name) const { return json_.contains(name); }
  const nlohmann::json& field(const char* name) const;
  const nlohmann::json& list(const char* name) const;
  std::string text(const char* name) const;
  bool boolean(const char* name) const;
  double number(const char* name, double least, double most = kLargest) const;
  int whole(const char* name, int least, int most) const;
  // A list of numbers, each from `least` to `most`.
  std::vector<double> numbers(const char* name, double least, double most = kLargest) const;

  // A list of as many finite numbers as V has.
  template <class V>
  V vector(const char* name) const {
    return vector<V>(name, field(name));
  }
  // The same for an element of the list `name`.
  template <class V>
  V vector(const char* name, const nlohmann::json& element) const {
    V out;
    require_size(name, element, static_cast<std::size_t>(out.size()));
    for (Eigen::Index i = 0; i < out.size(); ++i) {
      const double v = number_in(name, element[i], -kLargest, kLargest);
      out[i] = static_cast<typename V::Scalar>(v);
      if (!std::isfinite(out[i])) fail_too_large(name);  // as a float
    }
    return out;
  }

  // An element of the list `name` as a number in a range, or as a list of `size` elements.
  double number_in(const char* name, const nlohmann::json& element, double least, double most) const;
  void require_size(const char* name, const nlohmann::json& element, std::size_t size) const;

 private:
  [[noreturn]] void fail_too_large(const char* name) const;

  const nlohmann::json& json_;
  const JsonSource& source_;
  std::string what_;
  const char* code_;
};

}  // namespace terrazzo
