#include "nodes/study_anova/answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "graph/diagnostic.h"

namespace terrazzo::study_anova {

namespace {

struct Row {
  int line;
  std::vector<std::string> cells;
};

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> out{""};
  for (const char c : line) {
    if (c == ',')
      out.emplace_back();
    else if (c != '\r' && c != '"')
      out.back() += c;
  }
  return out;
}

// Rows with cells in the order of `columns`, whatever their order in the file.
std::vector<Row> rows_of(const std::string& text, const std::string& file,
                         const std::vector<std::string>& columns) {
  std::istringstream in(text);
  std::string line;
  std::vector<std::size_t> at;
  std::vector<Row> out;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \r\t") == std::string::npos) continue;
    const auto cells = split(line);
    if (at.empty()) {
      for (const auto& name : columns) {
        const auto found = std::find(cells.begin(), cells.end(), name);
        if (found == cells.end())
          throw Error("no-column", fmt::format("{} has no column '{}'", file, name),
                      "use the file as the study wrote it");
        at.push_back(static_cast<std::size_t>(found - cells.begin()));
      }
      continue;
    }
    Row row{number, {}};
    for (const std::size_t k : at) {
      if (k >= cells.size())
        throw Error("malformed-row", fmt::format("{}:{}: the row has {} cells, but column {} is needed", file,
                                                 number, cells.size(), k + 1));
      row.cells.push_back(cells[k]);
    }
    out.push_back(std::move(row));
  }
  if (at.empty()) throw Error("no-column", file + " is empty", "use the file as the study wrote it");
  return out;
}

double number_of(const std::string& text, const std::string& file, int line) {
  double v = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(v))
    throw Error("malformed-row", fmt::format("{}:{}: '{}' is not a number", file, line, text));
  return v;
}

}  // namespace

std::map<int, KeyEntry> read_key(const std::string& text, const std::string& file) {
  std::map<int, KeyEntry> out;
  for (const Row& r : rows_of(text, file, {"screen", "shape", "method", "decoy"})) {
    if (r.cells[3] != "left" && r.cells[3] != "right" && r.cells[3] != "none")
      throw Error("malformed-row", fmt::format("{}:{}: decoy must be left, right or none; it is '{}'", file,
                                               r.line, r.cells[3]));
    out[static_cast<int>(number_of(r.cells[0], file, r.line))] = {r.cells[1], r.cells[2], r.cells[3]};
  }
  return out;
}

std::vector<Answer> read_answers(const std::string& text, const std::string& file,
                                 const std::map<int, KeyEntry>& key) {
  std::vector<Answer> out;
  for (const Row& r : rows_of(text, file, {"participant", "screen", "choice", "seconds"})) {
    const double screen = number_of(r.cells[1], file, r.line);
    const auto entry = key.find(static_cast<int>(screen));
    if (entry == key.end())
      throw Error("no-such-screen", fmt::format("{}:{}: the key has no screen {}", file, r.line, r.cells[1]),
                  "use the key of the same study");
    if (r.cells[2] != "left" && r.cells[2] != "right")
      throw Error("malformed-row",
                  fmt::format("{}:{}: choice must be left or right; it is '{}'", file, r.line, r.cells[2]));
    out.push_back({r.cells[0], entry->second.shape, entry->second.method, entry->second.decoy, r.cells[2],
                   number_of(r.cells[3], file, r.line)});
  }
  return out;
}

}  // namespace terrazzo::study_anova
