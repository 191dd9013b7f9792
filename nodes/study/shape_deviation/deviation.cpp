#include "nodes/study/shape_deviation/deviation.h"

#include <fmt/format.h>

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/statistics/anova.h"

namespace terrazzo::shape_deviation {

namespace {

std::string word(const Table& t, std::size_t row, const char* column) {
  const int c = t.column(column);
  if (c < 0 || !std::holds_alternative<std::string>(t.rows[row][c]))
    throw Error("not-metrics", fmt::format("a table has no text column '{}'", column),
                "connect tables from ShapeMetrics");
  return std::get<std::string>(t.rows[row][c]);
}

}  // namespace

Table average_deviations(const std::vector<const Table*>& tables, const std::vector<std::string>& measures) {
  if (tables.empty() || tables[0]->rows.empty())
    throw Error("no-tables", "there are no tables to average", "connect tables from ShapeMetrics");
  const Table& first = *tables[0];
  Table out;
  out.columns = {"measure", "sections"};
  std::vector<std::string> names;
  for (std::size_t row = 0; row < first.rows.size() && word(first, row, "sections") == "central"; ++row)
    names.push_back(word(first, row, "name"));
  for (const char* what : {" %", " signed %"})
    for (std::size_t k = 1; k < names.size(); ++k) out.columns.push_back(names[k] + what);
  for (const Table* t : tables) {
    if (t->rows.size() != 2 * names.size())
      throw Error("other-methods",
                  fmt::format("a table has {} rows, but the first table requires {}", t->rows.size(),
                              2 * names.size()),
                  "use the same methods in every table");
    for (std::size_t row = 0; row < t->rows.size(); ++row)
      if (row % names.size() != 0 && word(*t, row, "name") != names[row % names.size()])
        throw Error("other-methods",
                    fmt::format("row {} is '{}' in one table and '{}' in another", row + 1,
                                names[row % names.size()], word(*t, row, "name")),
                    "use the same methods in every table");
  }
  for (const auto& measure : measures) {
    const std::string column = measure + " deviation %";
    if (first.column(column) < 0)
      throw Error("not-metrics", fmt::format("the tables have no column '{}'", column),
                  "set measures to names of ShapeMetrics measures");
    for (const bool central : {true, false}) {
      std::vector<Table::Cell> cells{measure, std::string(central ? "central" : "random")};
      for (const bool with_sign : {false, true})
        for (std::size_t k = 1; k < names.size(); ++k) {
          double sum = 0;
          for (const Table* t : tables) {
            const double deviation = t->number(k + (central ? 0 : names.size()), column);
            sum += with_sign ? deviation : std::abs(deviation);
          }
          cells.emplace_back(sum / tables.size());
        }
      out.rows.push_back(std::move(cells));
    }
  }
  return out;
}

Table effects(const std::vector<const Table*>& tables, const std::vector<std::string>& measures) {
  Table out;
  out.columns = {"measure",
                 "sections",
                 "effect",
                 "sum of squares",
                 "degrees of freedom",
                 "error sum of squares",
                 "error degrees of freedom",
                 "F",
                 "p"};
  const auto cell_of = [](double v) { return std::isnan(v) ? Table::Cell(std::string()) : Table::Cell(v); };
  const std::size_t names = tables.at(0)->rows.size() / 2;
  for (const auto& measure : measures)
    for (const bool central : {true, false}) {
      std::vector<AnovaCell> cells;
      for (std::size_t k = 0; k < tables.size(); ++k)
        for (std::size_t row = 1; row < names; ++row) {
          const std::size_t at = row + (central ? 0 : names);
          for (const std::string& column : {std::string("profiles"), measure + " mean", measure + " sd"})
            if (tables[k]->column(column) < 0)
              throw Error("not-metrics", fmt::format("a table has no column '{}'", column),
                          "connect tables from ShapeMetrics");
          AnovaCell cell;
          cell.a = word(*tables[k], at, "name");
          cell.b = fmt::format("{:09}", k);
          cell.n = tables[k]->number(at, "profiles");
          cell.mean = tables[k]->number(at, measure + " mean");
          const double sd = tables[k]->number(at, measure + " sd");  // of the sections: Σ (…)²/n
          cell.squares = cell.n * sd * sd;
          cells.push_back(std::move(cell));
        }
      for (const auto& e : two_way_anova(cells, {"method", "shape"}))
        out.rows.push_back({measure, std::string(central ? "central" : "random"), e.name, e.squares,
                            e.freedom, e.error_squares, e.error_freedom, cell_of(e.f), cell_of(e.p)});
    }
  return out;
}

}  // namespace terrazzo::shape_deviation
