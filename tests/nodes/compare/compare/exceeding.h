// Counts differences in a comparison.
#pragma once

#include <string>

#include "nodes/compare/compare/comparison.h"

namespace terrazzo::compare {

// Numbers of a measure that differ by more than their tolerance.
inline int exceeding(const Comparison& c, const std::string& measure) {
  int n = 0;
  for (const auto& x : c.numbers) n += x.measure == measure && x.exceeds();
  return n;
}

}  // namespace terrazzo::compare
