// A table with named columns, read row by row.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "nodes/common/io/cell_rows.h"
#include "nodes/sizes/load_profiles/column_header.h"

namespace terrazzo::load_profiles {

class MeasuredTable {
 public:
  // A table of one column without a header gets the header "area". Throws Error "no-particles", "no-column".
  MeasuredTable(const std::string& text, const std::string& file);

  // The first of the names that a column has. Of several columns of that name, one whose unit is a length,
  // else one without a unit, else the first.
  std::optional<std::size_t> column(std::initializer_list<const char*> names);
  // The header of a column, and its text as the file has it.
  const ColumnHeader& header(std::size_t column) const { return headers_[column - shift_]; }
  std::string name(std::size_t column) const;
  std::string names() const;
  const std::vector<ColumnHeader>& headers() const { return headers_; }

  // Reads the next row of a measurement. Returns false at the end. Rows that text in a column other than
  // `measured` names as a statistic of the others are left out.
  bool next(std::size_t measured);
  // The rows that next() left out: "Mean (line 402)".
  const std::vector<std::string>& statistics() const { return statistics_; }

  // Cells of the row that was read last. Throw Error "malformed-row".
  const std::string& text(std::size_t column) const { return row_.cells[column].text; }
  double number(std::size_t column) const;
  int whole(std::size_t column) const;
  [[noreturn]] void malformed(const std::string& what) const { rows_.malformed(row_.line, what); }

 private:
  // Numbers may be in quotes.
  std::optional<double> number_in(const CellRow::Cell& cell) const;
  // The name of the statistic that the row is; "" for a measurement.
  std::string statistic_of(std::size_t measured) const;

  std::string file_;
  CellReader rows_;
  std::vector<std::string> texts_;  // of the header
  std::vector<ColumnHeader> headers_;
  std::size_t shift_ = 0;         // columns without a header before the others
  std::optional<CellRow> first_;  // the first row below the header, until next() returns it
  CellRow row_;
  std::vector<std::string> statistics_;
};

}  // namespace terrazzo::load_profiles
