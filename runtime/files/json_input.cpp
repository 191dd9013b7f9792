#include "runtime/files/json_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "graph/diagnostic.h"
#include "graph/input_file.h"
#include "graph/text/utf8.h"
#include "runtime/memory.h"

namespace terrazzo {
namespace {

// Whether lists and objects are nested too deep. Exact up to the first mistake in the text, where parsing
// ends.
bool is_too_deep(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string && c == '\\')
      ++i;
    else if (c == '"')
      in_string = !in_string;
    else if (!in_string && (c == '{' || c == '['))
      ++depth;
    else if (!in_string && (c == '}' || c == ']'))
      --depth;
    if (depth > kDeepestJson) return true;
  }
  return false;
}

}  // namespace

nlohmann::json parse_json(std::string_view text) {
  if (is_too_deep(text))
    throw Error("bad-json", fmt::format("its values are nested more than {} deep", kDeepestJson));
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& e) {
    throw Error("bad-json", json_problem(e));
  }
}

nlohmann::json json_or_null(std::string_view text) {
  if (is_too_deep(text)) return nullptr;
  nlohmann::json out = nlohmann::json::parse(text, nullptr, false);
  if (out.is_discarded()) return nullptr;
  return out;
}

nlohmann::json read_json_file(const std::filesystem::path& path) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 30;
  const FileText file = read_input_file(path, kMost);
  if (file.too_large)
    throw Error("too-large", fmt::format("cannot read '{}': {}", path.string(), file.trouble));
  if (!file) return nullptr;
  require_memory(memory_to_read_json(file.text), available_memory(), "'" + path.string() + "'");
  return json_or_null(file.text);
}

// Each value takes 16 bytes, twice while its list grows; each list or object 80 more. A comma separates two.
double memory_to_read_json(std::string_view text) {
  return 64.0 * static_cast<double>(std::count(text.begin(), text.end(), ',') +
                                    std::count(text.begin(), text.end(), '[') +
                                    std::count(text.begin(), text.end(), '{')) +
         text.size();
}

std::string json_problem(const std::exception& e) {
  const std::string text = valid_utf8(e.what());
  const auto end = text.starts_with("[json.exception.") ? text.find("] ") : std::string::npos;
  return end == std::string::npos ? text : text.substr(end + 2);
}

}  // namespace terrazzo
