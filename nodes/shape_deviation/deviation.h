// Average deviations over tables of ShapeMetrics.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/table.h"

namespace terrazzo::shape_deviation {

// Columns: measure, sections, then a method each (all rows' names but the first): the mean over tables of the
// absolute deviation of that method's mean from the first row's, %. Throws Error "not-metrics" where a table
// lacks a column, "other-methods" where its rows' names are not the first table's.
Table average_deviations(const std::vector<const Table*>&, const std::vector<std::string>& measures);

}  // namespace terrazzo::shape_deviation
