// Labels: profile number of each pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/value.h"

namespace terrazzo {

struct Labels {
  int width = 0, height = 0, sections = 1;
  double pixel_size = 1;  // mm per pixel
  // Ordered as in Image; 0 is binder, profiles are numbered from 1 through all sections.
  std::vector<std::int32_t> ids;
  std::vector<std::int32_t> classes;  // class of profile id k at k − 1: color or particle class, from 0

  std::size_t index(int x, int y, int section = 0) const {
    return (static_cast<std::size_t>(section) * height + y) * width + x;
  }
  int count() const { return classes.size(); }
};

template <>
const ValueType& value_type<Labels>();

}  // namespace terrazzo
