// Tables and figure of an effective property.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/properties/homogenize/bounds.h"
#include "nodes/properties/homogenize/phases.h"

namespace terrazzo::homogenize {

struct Measure {
  std::string name, metric;  // metric: empty if it is none
  double value = 0;
  std::string unit;
  std::optional<double> coarse = {};  // the value at half the resolution
};

// Takes the values of measures of the same names as those at half the resolution.
void add_coarse_values(std::vector<Measure>&, const std::vector<Measure>& coarse);

// The table: columns measure, value, unit, half_resolution.
Table table_of(const std::vector<Measure>&);

// A tensor as a table: one column for each of `axes`, one row for each in the same order.
Table tensor_table(const Eigen::MatrixXd&, const std::vector<std::string>& axes);

// Diagonal values between bounds, beside a slice of a field through the middle, across z.
struct Shown {
  std::string title, value_label;
  std::vector<std::string> names;  // of the values
  std::vector<double> values;
  std::optional<Bounds> bounds;
  std::string bounds_name;
  const std::vector<float>* field = nullptr;  // of the voxels; empty: no slice
  std::string field_name;
};
Image figure_of(const Shown&, const VoxelBox&);

}  // namespace terrazzo::homogenize
