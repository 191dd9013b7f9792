// Whether boxes are the blocks of one cut.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "graph/diagnostic.h"
#include "nodes/volumes/blocks/cut.h"

namespace terrazzo::blocks {
namespace {

constexpr char kAxisNames[] = "xyz";

// The planes across one axis: where blocks begin, with the first block that begins there.
using Planes = std::map<int, std::size_t>;

Planes planes_across(int axis, const std::vector<Box>& blocks) {
  Planes out;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const auto [at, fresh] = out.try_emplace(blocks[k].low[axis], k);
    const int size = blocks[k].size[axis], other = blocks[at->second].size[axis];
    if (!fresh && size != other)
      throw Error(
          "unequal-blocks",
          fmt::format("block {} has {} voxels along {}, but block {}, which begins at the same {}, has {}", k,
                      size, kAxisNames[axis], at->second, kAxisNames[axis], other),
          "connect blocks of one cut");
  }
  for (auto at = out.begin(), next = std::next(at); next != out.end(); at = next++) {
    const int end = at->first + blocks[at->second].size[axis];
    if (end < next->first)
      throw Error("missing-blocks",
                  fmt::format("no block contains the voxels from {} to {} along {}", end, next->first - 1,
                              kAxisNames[axis]),
                  "connect all blocks of the solid");
    if (end > next->first)
      throw Error(
          "overlapping-blocks",
          fmt::format("blocks {} and {} overlap: along {}, one ends at voxel {} and the other begins at {}",
                      at->second, next->second, kAxisNames[axis], end - 1, next->first),
          "connect blocks of one cut");
  }
  return out;
}

}  // namespace

Box box_of(const std::vector<Box>& blocks) {
  if (blocks.empty()) throw Error("missing-blocks", "there are no blocks", "connect the blocks of a solid");
  std::map<std::array<int, 3>, std::size_t> begins;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const Vec3i& at = blocks[k].low;
    const auto [known, fresh] = begins.try_emplace({at.z(), at.y(), at.x()}, k);
    if (!fresh)
      throw Error("overlapping-blocks",
                  fmt::format("blocks {} and {} both begin at voxel ({}, {}, {})", known->second, k, at.x(),
                              at.y(), at.z()),
                  "connect each block once");
  }
  std::array<Planes, 3> planes;
  Box out;
  std::size_t count = 1;
  for (int a = 0; a < 3; ++a) {
    planes[a] = planes_across(a, blocks);
    count *= planes[a].size();
    const auto last = std::prev(planes[a].end());
    out.low[a] = planes[a].begin()->first;
    out.size[a] = last->first + blocks[last->second].size[a] - out.low[a];
  }
  // Each begins somewhere else, at crossing planes, so these are all unless some are missing.
  if (count == blocks.size()) return out;
  for (const auto& [z, of_z] : planes[2])
    for (const auto& [y, of_y] : planes[1])
      for (const auto& [x, of_x] : planes[0])
        if (!begins.count({z, y, x}))
          throw Error("missing-blocks",
                      fmt::format("no block begins at voxel ({}, {}, {}); {} of {} blocks are missing", x, y,
                                  z, count - blocks.size(), count),
                      "connect all blocks of the solid");
  return out;
}

}  // namespace terrazzo::blocks
