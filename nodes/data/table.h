// Table: named columns of numbers or text.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "runtime/value.h"

namespace terrazzo {

struct Table {
  using Cell = std::variant<double, std::string>;
  std::vector<std::string> columns;  // with the unit in the name: "area mm²"
  std::vector<std::vector<Cell>> rows;

  // −1 if there is none. A column that was renamed is found by either name.
  int column(const std::string& name) const;
  double number(std::size_t row,
                const std::string& name) const;  // throws Error "no-column", "no-row", "not-a-number"
};

template <>
const ValueType& value_type<Table>();

}  // namespace terrazzo
