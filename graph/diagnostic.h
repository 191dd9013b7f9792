// Diagnostics of all layers: messages with node, parameter and file:line:column.
#pragma once

#include <exception>
#include <string>
#include <vector>

namespace terrazzo {

// A location in a file. Lines and columns count from 1. 0 means that the line or the column is unknown.
struct Place {
  std::string file;
  int line = 0;
  int column = 0;
  std::string text() const;  // "file:line:column", without what is unknown, or ""
  bool operator==(const Place&) const = default;
};

enum class Severity { Error, Warning, Note };

struct Diagnostic {
  Severity severity = Severity::Error;
  std::string code;  // short and stable, for use in programs: "unknown-parameter", "jammed"
  std::string message;
  std::string hint;  // what the user can do; may be empty
  Place place;
  std::string node;       // path of the node, "asset/pack", may be empty
  std::string parameter;  // may be empty
  int item = -1;  // which item of the parameter's list is at fault, from 0; −1: the parameter as a whole
  // Where the enclosing subgraphs are used, innermost first.
  std::vector<Place> through = {};

  // "file:line:column: error: node.parameter: message (hint)", then one line per place in `through`
  std::string text() const;
};

using Diagnostics = std::vector<Diagnostic>;
bool has_errors(const Diagnostics&);

// The exception that nodes and readers throw. The runtime adds the node and the place if they are missing.
class Error : public std::exception {
 public:
  explicit Error(Diagnostic d);
  Error(std::string code, std::string message, std::string hint = {});
  // Names the parameter at fault. The runtime sets the place to where that parameter was set.
  Error& parameter(std::string name);
  // Names the item of that parameter's list. A check's error then has the place of the item.
  Error& item(int index);
  // Defined once, in diagnostic.cpp, since nearly every file throws errors and would compile them again.
  Error(const Error&);
  Error(Error&&) noexcept;
  Error& operator=(const Error&);
  Error& operator=(Error&&) noexcept;
  ~Error() override;
  const char* what() const noexcept override;
  const Diagnostic& diagnostic() const { return diagnostic_; }

 private:
  Diagnostic diagnostic_;
  std::string text_;
};

// Thrown from inside loops after the user cancels. Never shown as an error.
class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

}  // namespace terrazzo
