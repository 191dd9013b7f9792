// Voxel models made from formulas.
#pragma once

#include <tbb/global_control.h>

#include <array>
#include <functional>

#include "nodes/properties/homogenize/convergence.h"
#include "nodes/properties/homogenize/phases.h"
#include "runtime/random.h"

namespace terrazzo::test {

inline constexpr std::uint64_t kAmple = 1ull << 33;  // bytes
inline constexpr std::array<bool, 3> kAllAxes{true, true, true}, kAlongX{true, false, false};
inline constexpr homogenize::Accuracy kFine{1e-9, 2000}, kUsual{1e-6, 2000};

inline homogenize::PhaseMap phase_map(const Vec3i& size, std::size_t phases,
                                      const std::function<int(int x, int y, int z)>& phase,
                                      const Vec3& spacing = Vec3::Ones()) {
  homogenize::PhaseMap out;
  out.box.size = size;
  out.box.spacing = spacing;
  out.box.periodic = true;
  std::vector<double> voxels(phases, 0);
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) {
        out.phase.push_back(static_cast<std::uint8_t>(phase(x, y, z)));
        voxels[out.phase.back()] += 1;
      }
  for (std::size_t i = 0; i < phases; ++i) {
    out.names.push_back(std::to_string(i));
    out.fraction.push_back(voxels[i] / static_cast<double>(out.phase.size()));
  }
  return out;
}

inline homogenize::PhaseMap random_map(const Vec3i& size, std::size_t phases, std::uint64_t seed) {
  std::uint64_t item = 0;
  return phase_map(size, phases, [&](int, int, int) {
    Random r(seed, 1, item++);
    return static_cast<int>(r.uniform() * static_cast<double>(phases));
  });
}

// Phase 1 is a ball in the middle of a cube of n voxels, with this share of the cube's volume.
inline homogenize::PhaseMap ball(int n, double fraction, double spacing = 1) {
  const double radius = n * std::cbrt(3 * fraction / (4 * M_PI));
  return phase_map(
      Vec3i(n, n, n), 2,
      [&](int x, int y, int z) {
        return (Vec3(x, y, z) + Vec3::Constant(0.5 * (1 - n))).norm() < radius ? 1 : 0;
      },
      Vec3::Constant(spacing));
}

// The results of f with 1, 2 and 7 threads.
template <class F>
auto with_threads(F&& f) {
  std::vector<decltype(f())> out;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    out.push_back(f());
  }
  return out;
}

}  // namespace terrazzo::test
