// Periodic arrays of voxels.
#pragma once

#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/linear.h"

namespace terrazzo::patch_fill {

inline int wrapped(int i, int n) {
  i %= n;
  return i < 0 ? i + n : i;
}

// x fastest.
template <class T>
struct Torus {
  Vec3i size = Vec3i::Zero();
  std::vector<T> at;

  Torus() = default;
  Torus(const Vec3i& n, T value) : size(n), at(voxels_in(n), value) {}
  std::size_t index(int x, int y, int z) const { return voxel_at(x, y, z, size); }
  Vec3i place(std::size_t i) const {
    const int n = i;
    return Vec3i(n % size.x(), n / size.x() % size.y(), n / size.x() / size.y());
  }
};

// Half as many voxels along each axis, rounded up. Each is a smooth mean of the four voxels around it per
// axis.
template <class T>
Torus<T> half(const Torus<T>& fine, const T& zero) {
  const Vec3i n = fine.size;
  Torus<T> out(Vec3i((n.x() + 1) / 2, (n.y() + 1) / 2, (n.z() + 1) / 2), zero);
  for (std::size_t i = 0; i < out.at.size(); ++i) {
    const Vec3i p = 2 * out.place(i);
    T sum = zero;
    constexpr float kWeight[4] = {0.125f, 0.375f, 0.375f, 0.125f};
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
          sum += fine.at[fine.index(wrapped(p.x() + x - 1, n.x()), wrapped(p.y() + y - 1, n.y()),
                                    wrapped(p.z() + z - 1, n.z()))] *
                 (kWeight[x] * kWeight[y] * kWeight[z]);
    out.at[i] = sum;
  }
  return out;
}

}  // namespace terrazzo::patch_fill
