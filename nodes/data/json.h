// Helper of the `describe` functions: vectors as complete JSON lists.
#pragma once

#include <nlohmann/json.hpp>

#include "nodes/data/linear.h"

namespace terrazzo {

template <class V>
nlohmann::json json_of(const V& v) {
  nlohmann::json out = nlohmann::json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) out.push_back(v[i]);
  return out;
}

}  // namespace terrazzo
