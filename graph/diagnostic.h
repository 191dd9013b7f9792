// Messages with a place: what every layer reports, so that the user sees node, parameter and
// file:line:column.
#pragma once

#include <exception>
#include <string>
#include <vector>

namespace terrazzo {

// Where a thing was written. Lines and columns count from 1; line 0 means "nowhere in particular".
struct Place {
  std::string file;
  int line = 0;
  int column = 0;
  std::string text() const;  // "file:line:column", or "" where unknown
  bool operator==(const Place&) const = default;
};

enum class Severity { Error, Warning, Note };

struct Diagnostic {
  Severity severity = Severity::Error;
  std::string code;  // short and stable, for programs: "unknown-parameter", "jammed"
  std::string message;
  std::string hint;  // what to do, may be empty
  Place place;
  std::string node;       // path of the node, "asset/pack", may be empty
  std::string parameter;  // may be empty
  // Where the subgraphs around the place are used, innermost first.
  std::vector<Place> through = {};

  // "file:line:column: error: node.parameter: message (hint)", and a line for each place in `through`
  std::string text() const;
};

using Diagnostics = std::vector<Diagnostic>;
bool has_errors(const Diagnostics&);

// What a node or a reader throws. The runtime adds node and place where they are missing.
class Error : public std::exception {
 public:
  explicit Error(Diagnostic d);
  Error(std::string code, std::string message, std::string hint = {});
  // The parameter at fault, by name: the runtime turns it into the place where it was written.
  Error& parameter(std::string name);
  const char* what() const noexcept override { return text_.c_str(); }
  const Diagnostic& diagnostic() const { return diagnostic_; }

 private:
  Diagnostic diagnostic_;
  std::string text_;
};

// Thrown from within loops when the user cancelled; never an error message.
class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

}  // namespace terrazzo
