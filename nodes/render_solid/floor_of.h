#pragma once

namespace terrazzo::render_solid {

// std::floor is a function call on baseline x86-64.
inline int floor_of(float v) {
  const int i = static_cast<int>(v);
  return i - (static_cast<float>(i) > v);
}

}  // namespace terrazzo::render_solid
