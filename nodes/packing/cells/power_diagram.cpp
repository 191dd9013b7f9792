#include "nodes/packing/cells/power_diagram.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/periodic.h"
#include "nodes/packing/cells/voro.h"

namespace terrazzo::tessellation {
namespace {

constexpr double kPerBlock = 5;     // seeds per block of Voro++'s search grid
constexpr std::size_t kParts = 16;  // of the grid, each computed with a container of its own

// Voro++ compares with absolute tolerances, so lengths are in units of the mean cell.
double unit_of(const Seeds& s) { return std::cbrt(s.box.prod() / s.count()); }

// Calls visit(seed, cell) for each seed whose cell is not empty, from several threads.
template <class Visit>
void for_each_cell(const Seeds& s, const Work& work, const Visit& visit) {
  const double unit = unit_of(s);
  const Vec3 box = s.box / unit;
  int blocks[3];
  for (int a = 0; a < 3; ++a) blocks[a] = std::max<int>(1, std::round(box[a] / std::cbrt(kPerBlock)));
  const double least = *std::min_element(s.weight.begin(), s.weight.end());
  const auto cells = static_cast<std::size_t>(blocks[0]) * blocks[1] * blocks[2];
  work.parallel(cells, (cells + kParts - 1) / kParts, [&](std::size_t begin, std::size_t end) {
    // A container is not safe for several threads. All containers are equal, so the cells are too.
    voro::container_poly container(0, box[0], 0, box[1], 0, box[2], blocks[0], blocks[1], blocks[2], true,
                                   true, true, 8);
    for (std::size_t i = 0; i < s.count(); ++i) {
      const Vec3 p = s.position[i] / unit;
      container.put(static_cast<int>(i), p[0], p[1], p[2], std::sqrt(s.weight[i] - least) / unit);
    }
    voro::voronoicell_neighbor cell;
    for (std::size_t b = begin; b < end; ++b)
      for (int q = 0; q < container.co[b]; ++q) {
        if (q % 64 == 0) work.check();
        if (container.compute_cell(cell, static_cast<int>(b), q))
          visit(static_cast<std::size_t>(container.id[b][q]), cell, unit);
      }
  });
}

// Distance of two seeds with a face at height `face` above the first. The power plane lies at
// face = (d² + wa − wb) / 2d, which has two solutions d; `apart` is the vector between some images of the
// seeds.
double seed_distance(double face, double wa, double wb, const Vec3& apart, const Vec3& normal,
                     const Vec3& box) {
  const double root = std::sqrt(std::max(0.0, face * face - (wa - wb)));
  const auto error = [&](double d) { return nearest_image(apart - d * normal, box).squaredNorm(); };
  return error(face - root) < error(face + root) ? face - root : face + root;
}

}  // namespace

std::vector<ConvexCell> power_diagram(const Seeds& seeds, const Work& work) {
  std::vector<ConvexCell> cells(seeds.count());
  if (cells.empty()) return cells;
  for_each_cell(seeds, work, [&](std::size_t i, voro::voronoicell_neighbor& cell, double unit) {
    cells[i] = convert(cell, unit);
  });
  return cells;
}

CellSizes cell_sizes(const Seeds& seeds, const Work& work) {
  CellSizes out;
  out.volume.assign(seeds.count(), 0);
  out.centroid.assign(seeds.count(), Vec3::Zero());
  if (seeds.count() == 0) return out;
  std::vector<std::vector<CellSizes::Coupling>> couplings(seeds.count());
  for_each_cell(seeds, work, [&](std::size_t i, voro::voronoicell_neighbor& voro_cell, double unit) {
    const ConvexCell cell = convert(voro_cell, unit);
    out.volume[i] = cell.volume;
    out.centroid[i] = cell.centroid;
    for (const Face& f : cell.faces) {
      const std::size_t j = f.neighbor;
      if (f.neighbor < 0 || j == i) continue;  // an image of itself moves along
      const double face = f.normal.dot(cell.corners[f.corners[0]]);
      const double d = seed_distance(face, seeds.weight[i], seeds.weight[j],
                                     seeds.position[j] - seeds.position[i], f.normal, seeds.box);
      if (std::abs(d) > 1e-9 * unit)
        couplings[i].push_back({static_cast<std::int32_t>(i), f.neighbor, f.area / (2 * std::abs(d))});
    }
  });
  for (const auto& c : couplings) out.couplings.insert(out.couplings.end(), c.begin(), c.end());
  for (double v : out.volume) out.empty += v == 0;
  return out;
}

}  // namespace terrazzo::tessellation
