#include "nodes/properties/homogenize/connected.h"

#include <algorithm>

#include "nodes/common/geometry/grid/runs.h"
#include "nodes/properties/homogenize/vectors.h"

namespace terrazzo::homogenize {

Connected connected_across(const std::vector<std::uint8_t>& open, const VoxelBox& box,
                           const std::array<bool, 3>& axes, const Work& work) {
  std::vector<std::int8_t> labels(open.size());
  each(open.size(), work, [&](std::size_t i) { labels[i] = open[i] ? 0 : -1; });
  VoxelRuns runs(labels.data(), box, work);
  const auto reach = runs.reach(work);
  unsigned wanted = 0;
  for (int a = 0; a < 3; ++a) wanted |= static_cast<unsigned>(axes[a]) << a;
  Connected out;
  out.voxels.assign(open.size(), 0);
  for (std::size_t row = 0; row + 1 < runs.row_begin.size(); ++row) {
    if (row % 4096 == 0) work.check();
    for (std::size_t k = runs.row_begin[row]; k < runs.row_begin[row + 1]; ++k) {
      const unsigned across = reach[runs.root(k)];
      for (int a = 0; a < 3; ++a)
        if (across >> a & 1) out.along[a] = true;
      const VoxelRun& run = runs.runs[k];
      if (across & wanted)
        std::fill_n(out.voxels.begin() + row * box.size.x() + run.begin, run.end - run.begin, 1);
    }
  }
  return out;
}

}  // namespace terrazzo::homogenize
