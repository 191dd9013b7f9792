#include "nodes/packing/measure3d/minkowski.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numbers>
#include <numeric>

#include "nodes/packing/measure3d/directions13.h"

namespace terrazzo::measure3d {
namespace {

using Around = std::array<std::uint8_t, 8>;  // classes of a cube's voxels

// Adds a cube to the classes that it contains.
void add_cube(const Around& around, std::vector<Cubes>& cubes) {
  unsigned done = 0;  // voxels whose class was added
  for (std::size_t i = 0; i < 8; ++i) {
    if (done >> i & 1) continue;
    unsigned in = 0;
    for (std::size_t j = i; j < 8; ++j) in |= static_cast<unsigned>(around[j] == around[i]) << j;
    done |= in;
    ++cubes[around[i]][in];
  }
}

// Adds the cubes whose lower voxels are in the row (y, z).
void add_row(const Classes& classes, int y, int z, std::vector<Cubes>& cubes) {
  const Vec3i& n = classes.box.size;
  const int y2 = (y + 1) % n.y(), z2 = (z + 1) % n.z();
  const std::uint8_t* rows[4];
  for (int k = 0; k < 4; ++k) rows[k] = &classes.of[voxel_at(0, k & 1 ? y2 : y, k & 2 ? z2 : z, n)];
  const int count = classes.box.periodic ? n.x() : n.x() - 1;
  for (int x = 0; x < count; ++x) {
    const int x2 = x + 1 < n.x() ? x + 1 : 0;
    Around around;
    for (std::size_t k = 0; k < 4; ++k) {
      around[2 * k] = rows[k][x];
      around[2 * k + 1] = rows[k][x2];
    }
    std::uint64_t packed;
    std::memcpy(&packed, around.data(), sizeof packed);
    if (packed == around[0] * 0x0101010101010101u)
      ++cubes[around[0]][255];
    else
      add_cube(around, cubes);
  }
}

bool has(unsigned cube, std::size_t corner) { return cube >> corner & 1; }

// A cube's share of the Euler number of the union of closed voxels: it has one vertex, half of 6 edges, a
// quarter of 12 faces and an eighth of 8 voxels.
double euler_closed(unsigned cube) {
  double sum = cube != 0;
  for (const std::size_t axis : {1, 2, 4})
    for (const std::size_t side : {std::size_t{0}, axis}) {
      bool any = false;  // of the four voxels around the edge along the axis, on this side
      for (std::size_t c = 0; c < 8; ++c)
        if ((c & axis) == side) any |= has(cube, c);
      sum -= 0.5 * any;
    }
  for (std::size_t c = 0; c < 8; ++c)
    for (const std::size_t axis : {1, 2, 4})
      if (!(c & axis)) sum += 0.25 * (has(cube, c) || has(cube, c | axis));
  return sum - 0.125 * std::popcount(cube);
}

// The voxels of a cube in the plane of voxels number `plane` normal to direction d: 4 of them, of which the
// first and last are opposite, 3, or fewer, which are corners of what other cubes count.
std::vector<std::size_t> corners_of(std::size_t d, int plane) {
  std::vector<std::size_t> out;
  for (std::size_t c = 0; c < 8; ++c)
    if (kSteps[d][0] * static_cast<int>(c & 1) + kSteps[d][1] * static_cast<int>(c >> 1 & 1) +
            kSteps[d][2] * static_cast<int>(c >> 2) ==
        plane)
      out.push_back(c);
  return out;
}

// Share of the Euler number of a section, whose cells are four voxels: the mean for 4 and 8 neighbors.
double euler_of_four(unsigned cube, const std::vector<std::size_t>& c) {
  constexpr std::size_t kSides[4][2] = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  int voxels = 0, both = 0, either = 0;
  for (const std::size_t k : c) voxels += has(cube, k);
  for (const auto& side : kSides) {
    const bool a = has(cube, c[side[0]]), b = has(cube, c[side[1]]);
    both += a && b;
    either += a || b;
  }
  const double four = voxels / 4.0 - both / 2.0 + (voxels == 4);
  const double eight = (voxels > 0) - either / 2.0 + voxels / 4.0;
  return (four + eight) / 2;
}

// The same for triangles of voxels, where a voxel has six and a side has two.
double euler_of_three(unsigned cube, const std::vector<std::size_t>& c) {
  int voxels = 0;
  for (const std::size_t k : c) voxels += has(cube, k);
  return voxels / 6.0 - voxels * (voxels - 1) / 4.0 + (voxels == 3);
}

// A cube's share of the Euler number of the sections normal to direction d, per voxel.
double euler_of_section(unsigned cube, std::size_t d) {
  double sum = 0;
  for (int plane = -1; plane <= 2; ++plane) {
    const auto corners = corners_of(d, plane);
    // The faces of two cubes coincide.
    if (corners.size() == 4) sum += (d < kFaceDirections ? 0.5 : 1) * euler_of_four(cube, corners);
    if (corners.size() == 3) sum += euler_of_three(cube, corners);
  }
  return sum;
}

// Share of the cube's pairs of voxels along direction d of which one is in the class.
double crossings(unsigned cube, std::size_t d) {
  const int step = kSteps[d][0] + 2 * kSteps[d][1] + 4 * kSteps[d][2];
  double pairs = 0, crossed = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      const int to = static_cast<int>(c >> a & 1) + kSteps[d][a];
      inside = inside && to >= 0 && to <= 1;
    }
    if (!inside) continue;
    ++pairs;
    crossed += has(cube, c) != has(cube, c + step);
  }
  return crossed / pairs;
}

}  // namespace

std::vector<Cubes> count_cubes(const Classes& classes, const Work& work) {
  constexpr std::size_t kGrain = 4;  // planes
  const Vec3i& n = classes.box.size;
  const int less = classes.box.periodic ? 0 : 1;
  const std::vector<Cubes> none(classes.count(), Cubes{});
  auto out = work.reduce<std::vector<Cubes>>(
      n.z() - less, kGrain, none,
      [&](std::size_t begin, std::size_t end) {
        std::vector<Cubes> part = none;
        for (int z = begin; z < static_cast<int>(end); ++z)
          for (int y = 0; y < n.y() - less; ++y) add_row(classes, y, z, part);
        return part;
      },
      [](std::vector<Cubes> a, const std::vector<Cubes>& b) {
        for (std::size_t k = 0; k < a.size(); ++k)
          for (std::size_t c = 0; c < 256; ++c) a[k][c] += b[k][c];
        return a;
      });
  const std::uint64_t total = voxels_in(n - Vec3i::Constant(less));
  for (Cubes& cubes : out) cubes[0] = total - std::accumulate(cubes.begin(), cubes.end(), std::uint64_t{0});
  return out;
}

MinkowskiDensities minkowski_densities(const Cubes& cubes, const Vec3& spacing, bool faces_only) {
  MinkowskiDensities out;
  const double total = std::accumulate(cubes.begin(), cubes.end(), std::uint64_t{0});
  if (!(total > 0)) return out;
  std::array<Vec3, kDirectionCount> steps, normals;
  for (std::size_t d = 0; d < kDirectionCount; ++d) {
    steps[d] = step_of(d, spacing);
    normals[d] = normal_of(d, spacing);
  }
  const auto step_share = direction_shares(steps), normal_share = direction_shares(normals);
  const double voxel = spacing.prod();
  out.surface = out.curvature = out.euler = 0;
  for (unsigned cube = 0; cube < 256; ++cube) {
    if (cubes[cube] == 0) continue;
    const double share = cubes[cube] / total;
    // The rest, closed, has the Euler number of the open voxels: their common border has twice of either.
    out.euler += share / voxel * euler_closed(faces_only ? ~cube & 255 : cube);
    for (std::size_t d = 0; d < kDirectionCount; ++d) {
      out.surface += share * step_share[d] * 2 * crossings(cube, d) / steps[d].norm();
      out.curvature += share * normal_share[d] * 2 * std::numbers::pi * euler_of_section(cube, d) /
                       (voxel * normals[d].norm());
    }
  }
  return out;
}

}  // namespace terrazzo::measure3d
