#include "nodes/compare/load_table/read_table.h"

#include <fmt/format.h>

#include <limits>
#include <optional>

#include "nodes/common/io/cell_rows.h"
#include "nodes/common/io/json_input.h"

namespace terrazzo::load_table {
namespace {
using Json = nlohmann::json;
}  // namespace

Table read_csv(const std::string& text, const std::string& file, const Work& work) {
  CellReader rows(text, file);
  CellRow cells;
  if (!rows.next(cells))
    throw Error("no-column", "'" + file + "' is empty", "add a header line with the names of the columns")
        .parameter("path");
  Table out;
  for (auto& c : cells.cells) out.columns.push_back(std::move(c.text));
  while (rows.next(cells)) {
    if (out.rows.size() % 1024 == 0) work.check();
    rows.require_cells(cells, out.columns.size());
    auto& row = out.rows.emplace_back();
    row.reserve(cells.cells.size());
    for (auto& c : cells.cells) {
      const auto number = c.quoted ? std::nullopt : rows.number(c);
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
    const bool end = c == '\n' || c == '\r';
    cells += c == ',' || c == ';' || c == '\t' || end;
    rows += end || c == '[';
  }
  return memory_to_read_json(text) + (cells + rows + 1) * sizeof(Table::Cell) +
         (rows + 1) * 2 * sizeof(std::vector<Table::Cell>);
}

}  // namespace terrazzo::load_table
