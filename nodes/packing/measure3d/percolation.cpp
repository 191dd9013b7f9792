#include "nodes/packing/measure3d/percolation.h"

#include <algorithm>

#include "nodes/common/geometry/grid/runs.h"
#include "runtime/memory.h"

namespace terrazzo::measure3d {
namespace {

// Voxels of the pieces, at their roots.
std::vector<double> sizes_of(VoxelRuns& runs, const Work& work) {
  std::vector<double> out(runs.runs.size(), 0);
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (k % 65536 == 0) work.check();
    out[runs.root(k)] += runs.runs[k].end - runs.runs[k].begin;
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
  constexpr double kRunBytes = 64;  // of a run, its place among the pieces and its size
  require_memory(kRunBytes * count_runs(classes), memory, "the connected pieces");
  VoxelRuns runs(classes.of.data(), classes.box, work);
  const auto sizes = sizes_of(runs, work);
  const auto reach = runs.reach(work);
  // Numbers of voxels, which have no order of summation.
  std::vector<Percolation> out(classes.count());
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    if (!(sizes[k] > 0)) continue;
    Percolation& p = out[runs.runs[k].label];
    for (std::size_t a = 0; a < 3; ++a)
      if (reach[k] >> a & 1) p.across[a] += sizes[k];
    p.largest = std::max(p.largest, sizes[k]);
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
