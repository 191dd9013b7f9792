#include "nodes/load_table/read_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>

#include "nodes/common/io/json_input.h"

namespace terrazzo::load_table {
namespace {
using Json = nlohmann::json;

struct Cell {
  std::string text;
  bool quoted = false;
};

char separator_of(const std::string& header) {
  for (const char c : {'\t', ';'})
    if (header.find(c) != std::string::npos) return c;
  return ',';
}

// Rows of cells, one after the other.
class Rows {
 public:
  Rows(const std::string& text, const std::string& file) : text_(text), file_(file) {
    if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;
    skip_empty();
    separator_ = separator_of(text_.substr(at_, text_.find('\n', at_) - at_));
  }

  char separator() const { return separator_; }
  bool at_end() const { return at_ >= text_.size(); }
  int line() const { return line_; }  // of the row that was read last

  std::vector<Cell> next() {
    line_ = next_line_;
    std::vector<Cell> out(1);
    for (; at_ < text_.size() && text_[at_] != '\n'; ++at_) {
      if (text_[at_] == separator_)
        out.emplace_back();
      else if (text_[at_] == '"' && is_blank(out.back().text))
        read_quoted(out.back());
      else if (!(out.back().quoted && is_blank(text_.substr(at_, 1))))  // blanks after the quotes
        out.back().text += text_[at_];
    }
    for (Cell& c : out)
      if (!c.quoted) c.text = trimmed(c.text);
    skip_empty();
    return out;
  }

  [[noreturn]] void malformed(const std::string& what) const {
    throw Error("malformed-row", fmt::format("{}:{}: {}", file_, line_, what)).parameter("path");
  }

 private:
  const std::string& text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int line_ = 0, next_line_ = 1;
  char separator_ = ',';

  static bool is_blank(const std::string& s) { return s.find_first_not_of(" \t\r") == std::string::npos; }
  static std::string trimmed(const std::string& s) {
    const auto first = s.find_first_not_of(" \t\r"), last = s.find_last_not_of(" \t\r");
    return first == std::string::npos ? "" : s.substr(first, last - first + 1);
  }

  // From the opening quote to the closing one; two quotes are one.
  void read_quoted(Cell& cell) {
    cell = {"", true};
    for (++at_; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\n') ++next_line_;
      if (text_[at_] != '"')
        cell.text += text_[at_];
      else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"')
        cell.text += text_[at_++];
      else
        return;
    }
    malformed("a quotation mark is not closed");
  }

  // Moves from the end of a line to the next that is not empty.
  void skip_empty() {
    while (at_ < text_.size()) {
      if (text_[at_] == '\n') ++next_line_, ++at_;
      const auto end = std::min(text_.find('\n', at_), text_.size());
      if (!is_blank(text_.substr(at_, end - at_))) return;
      at_ = end;
    }
  }
};

std::optional<double> number_in(std::string cell, char separator) {
  if (separator != ',' && cell.find('.') == std::string::npos &&
      std::count(cell.begin(), cell.end(), ',') == 1)
    std::replace(cell.begin(), cell.end(), ',', '.');
  double v = 0;
  const char* first = cell.data() + (cell.size() > 1 && cell[0] == '+' && cell[1] != '-');
  const auto [end, error] = std::from_chars(first, cell.data() + cell.size(), v);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return v;
}

}  // namespace

Table read_csv(const std::string& text, const std::string& file, const Work& work) {
  Rows rows(text, file);
  if (rows.at_end())
    throw Error("no-column", "'" + file + "' is empty", "add a header line with the names of the columns")
        .parameter("path");
  Table out;
  for (Cell& c : rows.next()) out.columns.push_back(std::move(c.text));
  while (!rows.at_end()) {
    if (out.rows.size() % 1024 == 0) work.check();
    std::vector<Cell> cells = rows.next();
    if (cells.size() != out.columns.size())
      rows.malformed(fmt::format("{} cells; {} are expected", cells.size(), out.columns.size()));
    auto& row = out.rows.emplace_back();
    row.reserve(cells.size());
    for (Cell& c : cells) {
      const auto number = c.quoted ? std::nullopt : number_in(c.text, rows.separator());
      if (number)
        row.emplace_back(*number);
      else
        row.emplace_back(std::move(c.text));
    }
  }
  return out;
}

Table read_json(const std::string& text, const std::string& file, const Work& work) {
  const JsonSource source{file, "use a .json file that Export wrote from a table"};
  const Json json = parse_json(text, "table", source);
  const JsonObject all(json, source, "the table ", "bad-table");
  Table out;
  for (const Json& name : all.list("columns")) {
    if (!name.is_string()) all.fail("has a column whose name is not text");
    out.columns.push_back(name.get<std::string>());
  }
  for (const Json& cells : all.list("rows")) {
    const std::size_t k = out.rows.size();
    if (k % 1024 == 0) work.check();
    if (!cells.is_array() || cells.size() != out.columns.size())
      all.fail(fmt::format("has the row {}, which is not a list of {} cells", k, out.columns.size()));
    auto& row = out.rows.emplace_back();
    row.reserve(cells.size());
    for (const Json& cell : cells) {
      if (cell.is_number())
        row.emplace_back(cell.get<double>());
      else if (cell.is_null())  // JSON has no NaN
        row.emplace_back(std::numeric_limits<double>::quiet_NaN());
      else if (cell.is_string())
        row.emplace_back(cell.get<std::string>());
      else
        all.fail(fmt::format("has in row {} a cell that is neither number nor text", k));
    }
  }
  return out;
}

// Each cell takes two bytes of text at least, a cell of a table and one of the row as it is read; a row,
// whose list may grow to twice its length, an end of line.
double memory_to_read(const std::string& text) {
  double cells = 0, rows = 0;
  for (const char c : text) {
    cells += c == ',' || c == ';' || c == '\t' || c == '\n';
    rows += c == '\n' || c == '[';
  }
  return memory_to_read_json(text) + (cells + rows + 1) * sizeof(Table::Cell) +
         (rows + 1) * 2 * sizeof(std::vector<Table::Cell>);
}

}  // namespace terrazzo::load_table
