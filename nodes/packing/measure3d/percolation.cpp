#include "nodes/packing/measure3d/percolation.h"

#include <algorithm>

#include "nodes/packing/measure3d/runs.h"
#include "runtime/memory.h"

namespace terrazzo::measure3d {
namespace {

struct Extent {
  double voxels = 0;
  unsigned low = 0, high = 0;  // sides of the box that it touches, by axis (bits 0 to 2)
};

// Of the pieces, at their roots.
std::vector<Extent> extents_of(Runs& runs, const Vec3i& n, const Work& work) {
  std::vector<Extent> out(runs.runs.size());
  for (std::size_t row = 0; row + 1 < runs.row_begin.size(); ++row) {
    if (row % 4096 == 0) work.check();
    const int y = row % n.y(), z = row / n.y();
    for (std::size_t k = runs.row_begin[row]; k < runs.row_begin[row + 1]; ++k) {
      const Run& run = runs.runs[k];
      Extent& e = out[runs.root(k)];
      e.voxels += run.end - run.begin;
      e.low |= (run.begin == 0) | (y == 0) << 1 | (z == 0) << 2;
      e.high |= (run.end == n.x()) | (y == n.y() - 1) << 1 | (z == n.z() - 1) << 2;
    }
  }
  return out;
}

// Upper limit of their number.
std::size_t count_runs(const Classes& classes) {
  std::size_t count = pixels_in(classes.box.size.y(), classes.box.size.z());
  for (std::size_t i = 1; i < classes.of.size(); ++i) count += classes.of[i] != classes.of[i - 1];
  return count;
}

}  // namespace

std::vector<Percolation> percolation_of(const Classes& classes, std::uint64_t memory, const Work& work) {
  constexpr double kRunBytes = 64;  // of a run, its place among the pieces and its extent
  require_memory(kRunBytes * count_runs(classes), memory, "the connected pieces");
  Runs runs(classes.of.data(), classes.box, work);
  const auto extents = extents_of(runs, classes.box.size, work);
  // Numbers of voxels, which have no order of summation.
  std::vector<Percolation> out(classes.count());
  for (std::size_t k = 0; k < extents.size(); ++k) {
    const Extent& e = extents[k];
    if (!(e.voxels > 0)) continue;
    Percolation& p = out[runs.runs[k].label];
    const unsigned across = classes.box.periodic ? runs.winding(k) : e.low & e.high;
    for (std::size_t a = 0; a < 3; ++a)
      if (across >> a & 1) p.across[a] += e.voxels;
    p.largest = std::max(p.largest, e.voxels);
    ++p.pieces;
  }
  for (std::size_t k = 0; k < out.size(); ++k) {
    const double voxels = std::max<double>(1, classes.voxels[k]);
    for (double& share : out[k].across) share /= voxels;
    out[k].largest /= voxels;
  }
  return out;
}

}  // namespace terrazzo::measure3d
