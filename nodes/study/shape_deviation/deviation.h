// Averages deviations over tables from ShapeMetrics.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/table.h"

namespace terrazzo::shape_deviation {

// Columns: measure, sections, then one per method (the names of all rows but the first): the mean over the
// tables of the absolute deviation of the method's mean from that of the first row, %; then the same with
// signs, in which opposite errors cancel. Throws Error
// "no-tables" without tables or rows, "not-metrics" if a table lacks a column, "other-methods" if its row
// names differ from those of the first table.
Table average_deviations(const std::vector<const Table*>&, const std::vector<std::string>& measures);

// Two-way analyses of variance of each measure by method (all rows but the first) and original (table), with
// interaction, computed from the numbers, means and standard deviations in the tables. Columns: measure,
// sections, effect, sum of squares, degrees of freedom, error sum of squares, error degrees of freedom, F, p.
// F and p are empty where they are undefined. Throws as average_deviations, which must accept the tables.
Table effects(const std::vector<const Table*>&, const std::vector<std::string>& measures);

}  // namespace terrazzo::shape_deviation
