#include "graph/diagnostic.h"

#include <algorithm>

#include "graph/text/utf8.h"

namespace terrazzo {

std::string Place::text() const {
  if (file.empty()) return {};
  if (line <= 0) return file;
  const std::string at = file + ":" + std::to_string(line);
  return column > 0 ? at + ":" + std::to_string(column) : at;
}

std::string Diagnostic::text() const {
  std::string out = escape_line(place.text());
  if (!out.empty()) out += ": ";
  out += severity == Severity::Error ? "error: " : severity == Severity::Warning ? "warning: " : "note: ";
  if (!node.empty()) out += escape_line(node + (parameter.empty() ? "" : "." + parameter)) + ": ";
  out += printable(message, std::string::npos);
  // May have several lines: where a node in Python failed.
  if (!hint.empty()) out += " (" + escape_controls(hint) + ")";
  for (const auto& p : through) out += "\n  in the graph used at " + escape_line(p.text());
  return out;
}

bool has_errors(const Diagnostics& all) {
  return std::any_of(all.begin(), all.end(), [](const auto& d) { return d.severity == Severity::Error; });
}

Error::Error(Diagnostic d) : diagnostic_(std::move(d)), text_(diagnostic_.text()) {}

Error::Error(std::string code, std::string message, std::string hint)
    : Error(Diagnostic{Severity::Error, std::move(code), std::move(message), std::move(hint), {}, {}, {}}) {}

Error::Error(const Error&) = default;
Error::Error(Error&&) noexcept = default;
Error& Error::operator=(const Error&) = default;
Error& Error::operator=(Error&&) noexcept = default;
Error::~Error() = default;
const char* Error::what() const noexcept { return text_.c_str(); }

Error& Error::parameter(std::string name) {
  diagnostic_.parameter = std::move(name);
  text_ = diagnostic_.text();
  return *this;
}

Error& Error::item(int index) {
  diagnostic_.item = index;
  return *this;
}

}  // namespace terrazzo
