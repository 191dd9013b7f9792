#include "nodes/data/table.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace terrazzo {

namespace {

// Columns of earlier versions with their present names. Readers that ask for either find the other, since
// tables may come from a cache or a file of another version.
constexpr const char* kFormerColumns[][2] = {
    {"told %", "accuracy %"}, {"told by", "main feature"}, {"share of the volume", "volume share"},
    {"of", "quantity"},       {"centre", "center"},
};

}  // namespace

int Table::column(const std::string& name) const {
  const auto find = [&](const std::string& n) {
    const auto it = std::find(columns.begin(), columns.end(), n);
    return it == columns.end() ? -1 : static_cast<int>(it - columns.begin());
  };
  int found = find(name);
  for (const auto& [former, present] : kFormerColumns) {
    if (found < 0 && name == former) found = find(present);
    if (found < 0 && name == present) found = find(former);
  }
  return found;
}

double Table::number(std::size_t row, const std::string& name) const {
  const int c = column(name);
  if (c < 0) throw Error("no-column", "the table has no column '" + name + "'");
  if (row >= rows.size()) throw Error("no-row", "the table has no row " + std::to_string(row));
  if (const auto* v = std::get_if<double>(&rows[row].at(c))) return *v;
  throw Error("not-a-number", "row " + std::to_string(row) + " of column '" + name + "' is not a number");
}

namespace {

void encode(const Table& v, Writer& w) {
  w.pod<std::uint64_t>(v.columns.size());
  for (const auto& c : v.columns) w.text(c);
  w.pod<std::uint64_t>(v.rows.size());
  for (const auto& row : v.rows) {
    if (row.size() != v.columns.size())
      throw Error("bad-table", "a row of the table differs in length from the header");
    for (const auto& cell : row) {
      w.pod<std::uint8_t>(cell.index() == 0 ? 0 : 1);
      if (cell.index() == 0)
        w.pod(std::get<double>(cell));
      else
        w.text(std::get<std::string>(cell));
    }
  }
}

Table decode_table(Reader& r) {
  Table v;
  v.columns.resize(r.count(8));
  for (auto& c : v.columns) c = r.text();
  v.rows.resize(r.count(9 * std::max<std::size_t>(v.columns.size(), 1)));
  for (auto& row : v.rows) {
    row.resize(v.columns.size());
    for (auto& cell : row) {
      if (r.pod<std::uint8_t>() == 0)
        cell = r.pod<double>();
      else
        cell = r.text();
    }
  }
  return v;
}

nlohmann::json describe(const Table& v) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& row : v.rows) {
    nlohmann::json out = nlohmann::json::array();
    for (const auto& cell : row) std::visit([&](const auto& x) { out.push_back(x); }, cell);
    rows.push_back(std::move(out));
  }
  return {{"columns", v.columns}, {"rows", std::move(rows)}};
}

}  // namespace

template <>
const ValueType& value_type<Table>() {
  static const ValueType type =
      make_value_type<Table>("Table", "Named columns of numbers or text", encode, decode_table, describe);
  return type;
}

}  // namespace terrazzo
