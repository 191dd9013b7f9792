#include "nodes/sizes/load_profiles/measured_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "graph/diagnostic.h"
#include "nodes/common/io/reading.h"

namespace terrazzo::load_profiles {
namespace {

// Whether the header is that of a column `name`: its name, or its name with a unit joined to it ("areaum2").
// The unit is then part of `out`.
bool has_name(const ColumnHeader& header, std::string_view name, ColumnHeader& out) {
  out = header;
  if (header.name == name) return true;
  if (!header.unit_text.empty() || !header.name.starts_with(name)) return false;
  out.name = name;
  out.unit_text = header.name.substr(name.size());
  out.unit = unit_of(out.unit_text);
  return out.unit.has_value();
}

// 0: in a unit of length; 1: without a unit; 2: in pixels, percent, or an unknown unit.
int preference(const ColumnHeader& header) {
  if (header.unit_text.empty()) return 1;
  return header.unit && header.unit->mm > 0 ? 0 : 2;
}

// Names of statistics in the tables of ImageJ, spreadsheets, R (summary) and pandas (describe).
bool is_statistic(std::string_view label) {
  static const std::set<std::string, std::less<>> names = {"mean",
                                                           "average",
                                                           "avg",
                                                           "meanvalue",
                                                           "arithmeticmean",
                                                           "sd",
                                                           "std",
                                                           "stddev",
                                                           "stdev",
                                                           "stdevp",
                                                           "standarddeviation",
                                                           "stderr",
                                                           "sem",
                                                           "standarderror",
                                                           "variance",
                                                           "min",
                                                           "minimum",
                                                           "max",
                                                           "maximum",
                                                           "median",
                                                           "sum",
                                                           "total",
                                                           "count",
                                                           "range",
                                                           "skewness",
                                                           "kurtosis",
                                                           "1stqu",
                                                           "3rdqu",
                                                           "25%",
                                                           "50%",
                                                           "75%",
                                                           "mittelwert",
                                                           "standardabweichung",
                                                           "summe",
                                                           "anzahl",
                                                           "moyenne",
                                                           "ecarttype",
                                                           "somme"};
  return names.count(label) > 0;
}

}  // namespace

MeasuredTable::MeasuredTable(const std::string& text, const std::string& file)
    : file_(file), rows_(text, file, {.separators = "\t;, ", .comments = true}) {
  CellRow header;
  if (!rows_.next(header)) throw Error("no-particles", "'" + file_ + "' contains no rows").parameter("path");
  const bool numbers = std::all_of(header.cells.begin(), header.cells.end(),
                                   [&](const auto& cell) { return number_in(cell).has_value(); });
  for (const auto& c : header.cells) texts_.push_back(c.text);
  if (numbers) {
    if (texts_.size() != 1)
      throw Error("no-column", fmt::format("'{}' has {} columns but no header line", file_, texts_.size()),
                  "add a header line that names a column area or diameter")
          .parameter("path");
    texts_ = {"area"};
    first_ = std::move(header);
  } else if (CellRow row; rows_.next(row)) {
    // Some programs number the rows without a header for that column.
    if (row.cells.size() == texts_.size() + 1) shift_ = 1;
    first_ = std::move(row);
  }
  for (const std::string& t : texts_) headers_.push_back(read_header(t));
}

std::optional<std::size_t> MeasuredTable::column(std::initializer_list<const char*> names) {
  for (const char* name : names) {
    std::optional<std::size_t> best;
    ColumnHeader best_header, header;
    for (std::size_t i = 0; i < headers_.size(); ++i)
      if (has_name(headers_[i], name, header) && (!best || preference(header) < preference(best_header))) {
        best = i;
        best_header = header;
      }
    if (!best) continue;
    headers_[*best] = best_header;
    return *best + shift_;
  }
  return std::nullopt;
}

std::string MeasuredTable::name(std::size_t column) const {
  return column < shift_ ? "1" : printable(texts_[column - shift_]);
}

std::string MeasuredTable::names() const {
  std::string all;
  for (const auto& t : texts_) all += (all.empty() ? "" : ", ") + (t.empty() ? "''" : t);
  return printable(all);
}

std::optional<double> MeasuredTable::number_in(const CellRow::Cell& cell) const {
  return cell_number(trimmed_cell(cell.text), rows_.separator() != ',');
}

std::string MeasuredTable::statistic_of(std::size_t measured) const {
  for (std::size_t i = 0; i < row_.cells.size(); ++i)
    if (i != measured && is_statistic(plain_name(row_.cells[i].text))) return row_.cells[i].text;
  return {};
}

bool MeasuredTable::next(std::size_t measured) {
  for (;;) {
    if (first_) {
      row_ = std::move(*first_);
      first_.reset();
    } else if (!rows_.next(row_)) {
      return false;
    }
    const std::string statistic = statistic_of(measured);
    if (statistic.empty()) break;
    statistics_.push_back(fmt::format("{} (line {})", printable(statistic), row_.line));
  }
  rows_.require_cells(row_, texts_.size() + shift_);
  return true;
}

double MeasuredTable::number(std::size_t column) const {
  const auto v = number_in(row_.cells[column]);
  if (!v || !std::isfinite(*v))
    malformed("'" + printable(text(column)) + "' is not a number (column " + name(column) + ")");
  return *v;
}

int MeasuredTable::whole(std::size_t column) const {
  const double v = number(column);
  if (v < 0 || v != std::floor(v) || v > 1e9)
    malformed("'" + printable(text(column)) + "' is not a whole number ≥ 0 (column " + name(column) + ")");
  return static_cast<int>(v);
}

}  // namespace terrazzo::load_profiles
