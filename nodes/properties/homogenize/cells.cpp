#include "nodes/properties/homogenize/cells.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "runtime/memory.h"

namespace terrazzo::homogenize {
namespace {

constexpr int kFewest = 4;  // cells along each axis of the coarsest level
constexpr std::size_t kMostCells = 0xffff0000;
constexpr int kLongest = 65535;  // voxels along an axis, so that a segment takes 40 bytes

// Whether a cell's neighbor in another row follows the neighbor of the segment's last cell.
bool follows(std::uint32_t first, int length, std::uint32_t next) {
  return first == 0 ? next == 0 : next == first + length;
}

bool continues(const Segment& s, const Segment& cell) {
  return s.y == cell.y && s.x + s.length == cell.x && s.seams == cell.seams &&
         follows(s.south, s.length, cell.south) && follows(s.north, s.length, cell.north) &&
         follows(s.below, s.length, cell.below) && follows(s.above, s.length, cell.above);
}

}  // namespace

Cells::Cells(const Vec3i& size, const std::array<bool, 3>& wraps, const std::vector<std::uint8_t>& open,
             std::vector<std::uint32_t>& index, std::uint64_t memory, const Work& work)
    : size_(size) {
  if (size.maxCoeff() > kLongest)
    throw Error("too-large",
                fmt::format("an axis has {} voxels; at most {} are supported", size.maxCoeff(), kLongest),
                "use a smaller volume");
  for (int a = 0; a < 3; ++a) seams_ += wraps[a] && size[a] > 1 && size[a] % 2 == 1;
  const std::size_t plane = pixels_in(size.x(), size.y());
  std::vector<std::size_t> at(size.z() + 1, 0);
  work.parallel(size.z(), 1, [&](std::size_t z, std::size_t) {
    at[z + 1] = plane - std::count(&open[z * plane], &open[z * plane] + plane, 0);
  });
  at[0] = first();
  for (int z = 0; z < size.z(); ++z) at[z + 1] += at[z];
  length_ = at.back();
  if (length_ > kMostCells)
    throw Error("too-large", "more than 4.29e9 voxels are open", "use a smaller volume");
  index.resize(open.size());
  work.parallel(size.z(), 1, [&](std::size_t z, std::size_t) {
    std::uint32_t next = at[z];
    for (std::size_t i = z * plane; i < (z + 1) * plane; ++i) index[i] = open[i] ? next++ : 0;
  });
  // Counted first, since in noise there are nearly as many segments as cells.
  plane_begin_.assign(size.z() + 1, 0);
  each_plane(size.z(), 1, work, [&](int z) { plane_begin_[z + 1] = segments_of(z, wraps, index).size(); });
  for (int z = 0; z < size.z(); ++z) plane_begin_[z + 1] += plane_begin_[z];
  require_memory(1.0 * sizeof(Segment) * plane_begin_.back(), memory, "the network of open voxels");
  segments_.resize(plane_begin_.back());
  each_plane(size.z(), 1, work, [&](int z) {
    const auto segments = segments_of(z, wraps, index);
    std::copy(segments.begin(), segments.end(), segments_.begin() + plane_begin_[z]);
  });
}

std::vector<Segment> Cells::segments_of(int z, const std::array<bool, 3>& wraps,
                                        const std::vector<std::uint32_t>& index) const {
  const Vec3i& n = size_;
  // Where a coordinate goes by a step of an axis; −1: out of the box.
  const auto moved = [&](int axis, int at, int by) {
    const int to = at + by;
    if (to >= 0 && to < n[axis]) return to;
    return !wraps[axis] ? -1 : to < 0 ? n[axis] - 1 : 0;
  };
  const auto number = [&](int x, int y, int z) {
    return x < 0 || y < 0 || z < 0 ? 0 : index[voxel_at(x, y, z, n)];
  };
  const auto last_of_odd = [&](int axis, int at) {
    return wraps[axis] && n[axis] > 1 && n[axis] % 2 == 1 && at == n[axis] - 1;
  };
  const int below = moved(2, z, -1), above = moved(2, z, 1);
  std::vector<Segment> out;
  for (int y = 0; y < n.y(); ++y) {
    const int south = moved(1, y, -1), north = moved(1, y, 1);
    for (int x = 0; x < n.x(); ++x) {
      const std::uint32_t at = number(x, y, z);
      if (at == 0) continue;
      Segment cell{};
      cell.at = at;
      cell.west = number(moved(0, x, -1), y, z);
      cell.east = number(moved(0, x, 1), y, z);
      cell.south = number(x, south, z);
      cell.north = number(x, north, z);
      cell.below = number(x, y, below);
      cell.above = number(x, y, above);
      cell.x = x;
      cell.y = y;
      cell.length = 1;
      cell.seams = last_of_odd(0, x) + last_of_odd(1, y) + last_of_odd(2, z);
      if (!out.empty() && continues(out.back(), cell)) {
        ++out.back().length;
        out.back().east = cell.east;
      } else {
        out.push_back(cell);
      }
    }
  }
  return out;
}

std::size_t Cells::grain() const {
  const std::size_t cells = std::max<std::size_t>(1, length_ - first());
  return std::max<std::size_t>(1, (1 << 15) * static_cast<std::size_t>(size_.z()) / cells);
}

std::vector<Cells> levels_of(const Vec3i& size, const std::array<bool, 3>& wraps,
                             const std::vector<std::uint8_t>& open, std::uint64_t memory, const Work& work) {
  std::vector<std::uint32_t> index;
  std::vector<Cells> out;
  out.push_back(Cells(size, wraps, open, index, memory, work));
  std::vector<std::uint8_t> merged;
  while (out.back().size().maxCoeff() > kFewest) {
    Cells& cells = out.back();
    const Vec3i n = cells.size(), m = (n.array() + 1) / 2;
    merged.assign(voxels_in(m), 0);
    each_plane(m.z(), 1, work, [&](int half) {
      for (int z = 2 * half; z < std::min(2 * half + 2, n.z()); ++z)
        for (const Segment& s : cells.plane(z))
          for (int x = s.x; x < s.x + s.length; ++x) merged[voxel_at(x / 2, s.y / 2, z / 2, m)] = 1;
    });
    Cells coarser(m, wraps, merged, index, memory, work);
    each_plane(n.z(), 1, work, [&](int z) {
      for (std::size_t k = cells.plane_begin_[z]; k < cells.plane_begin_[z + 1]; ++k) {
        Segment& s = cells.segments_[k];
        s.parent = index[voxel_at(s.x / 2, s.y / 2, z / 2, m)];
      }
    });
    out.push_back(std::move(coarser));
  }
  return out;
}

template <class T>
std::vector<float> of_voxels(const Cells& cells, const std::vector<T>& values, const Work& work) {
  std::vector<float> out(voxels_in(cells.size()), 0);
  each_segment(cells, work, [&](const Segment& s, int z) {
    const std::size_t voxel = cells.voxel(s, z);
    for (int i = 0; i < s.length; ++i) out[voxel + i] = static_cast<float>(values[s.at + i]);
  });
  return out;
}
template std::vector<float> of_voxels(const Cells&, const std::vector<float>&, const Work&);
template std::vector<float> of_voxels(const Cells&, const std::vector<double>&, const Work&);

}  // namespace terrazzo::homogenize
