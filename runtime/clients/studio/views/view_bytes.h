// Bytes of the views that the page reads as typed arrays.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include "nodes/data/linear.h"

namespace terrazzo::studio {

static_assert(std::endian::native == std::endian::little, "the page reads little-endian numbers");

template <class T>
void append(std::string& out, T v) {
  static_assert(sizeof(T) == 4);
  char bytes[4];
  std::memcpy(bytes, &v, 4);
  out.append(bytes, 4);
}

// sRGB bytes of a scene-linear color, opaque. NaN is black.
std::uint32_t rgba(const Vec3f& linear);
// A color for a number of a profile or particle: neighbors in number differ. 0 and below are nearly black.
std::uint32_t color_of(std::int32_t id);

}  // namespace terrazzo::studio
