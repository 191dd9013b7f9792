// Table: named columns of numbers or words.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "runtime/value.h"

namespace terrazzo {

struct Table {
  using Cell = std::variant<double, std::string>;
  std::vector<std::string> columns;  // units in the name: "area mm²"
  std::vector<std::vector<Cell>> rows;

  int column(const std::string& name) const;                      // −1 where there is none
  double number(std::size_t row, const std::string& name) const;  // throws Error where it is no number
};

template <>
const ValueType& value_type<Table>();

}  // namespace terrazzo
