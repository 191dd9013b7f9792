// Places in arrays that are stored row by row, and whole numbers from real ones.
#pragma once

#include <cmath>
#include <cstddef>

#include "nodes/data/linear.h"

namespace terrazzo {

// Numbers and places may exceed an int, sizes and coordinates do not.
inline std::size_t pixels_in(int width, int height) { return static_cast<std::size_t>(width) * height; }
inline std::size_t pixel_at(int x, int y, int width) { return static_cast<std::size_t>(y) * width + x; }
inline std::size_t voxels_in(const Vec3i& size) { return pixels_in(size.x(), size.y()) * size.z(); }
inline std::size_t voxel_at(int x, int y, int z, const Vec3i& size) {
  return (static_cast<std::size_t>(z) * size.y() + y) * size.x() + x;
}

// Larger types are refused, not cut.
template <class A, class B>
std::size_t pixels_in(A, B) = delete;
template <class A, class B, class C>
std::size_t pixel_at(A, B, C) = delete;
template <class A, class B, class C>
std::size_t voxel_at(A, B, C, const Vec3i&) = delete;

// Down, up, and to the nearest, halves away from zero. The result must fit into an int.
inline int round_down(double v) { return static_cast<int>(std::floor(v)); }
inline int round_up(double v) { return static_cast<int>(std::ceil(v)); }
inline int round_nearest(double v) { return static_cast<int>(std::lround(v)); }

// The number of items as an int, to compare it with one.
template <class Items>
int count_of(const Items& items) {
  return static_cast<int>(items.size());
}

}  // namespace terrazzo
