// Rounds a number down without a function call.
#pragma once

namespace terrazzo {

// std::floor is a function call on baseline x86-64. `v` must fit into an int.
inline int floor_of(float v) {
  const int i = v;
  return i - (static_cast<float>(i) > v);
}

}  // namespace terrazzo
