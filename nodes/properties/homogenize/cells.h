// The voxels of a box in which something flows, row by row, and the coarser levels of multigrid. Only they
// have a place in arrays, so that a rock needs the memory and time of its pores.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::homogenize {

// Cells that follow each other along x. In each of the four rows around, their neighbors follow each other
// too, or all are absent. Index 0 stands for an absent neighbor.
struct Segment {
  std::uint32_t at;                          // of the first cell
  std::uint32_t west, east;                  // before the first and after the last cell
  std::uint32_t south, north, below, above;  // beside the first cell: y − 1, y + 1, z − 1, z + 1
  std::uint32_t parent;                      // of the first cell on the coarser level
  std::uint16_t x, y, length;                // where the first cell is, and how many there are
  std::uint16_t seams;  // number of axes along which the cells are the last of an odd number

  // The neighbor of cell i of the segment along an axis; below Cells::first() if it is absent.
  std::uint32_t next(int axis, int i) const {
    if (axis == 0) return i + 1 < length ? at + i + 1 : east;
    return (axis == 1 ? north : above) + i;
  }
  std::uint32_t previous(int axis, int i) const {
    if (axis == 0) return i > 0 ? at + i - 1 : west;
    return (axis == 1 ? south : below) + i;
  }
};

// Where cell i of a segment of plane z is along an axis.
inline int coordinate(const Segment& s, int i, int z, int axis) {
  return axis == 0 ? s.x + i : axis == 1 ? s.y : z;
}

// Arrays over cells have length() values. The first first() of them belong to absent neighbors, and are zero.
class Cells {
 public:
  const Vec3i& size() const { return size_; }
  std::size_t first() const { return size_.x(); }
  std::size_t length() const { return length_; }
  // The segments of a plane, in order.
  std::span<const Segment> plane(int z) const {
    return {segments_.data() + plane_begin_[z], segments_.data() + plane_begin_[z + 1]};
  }
  // The voxel of the first cell of a segment of plane z.
  std::size_t voxel(const Segment& s, int z) const {
    return voxel_at(static_cast<int>(s.x), static_cast<int>(s.y), z, size_);
  }
  int seams() const { return seams_; }  // number of axes that wrap around an odd number of cells above 1
  std::size_t grain() const;            // planes of one range of a parallel loop, of at least 2¹⁵ cells
  double bytes() const { return 1.0 * sizeof(Segment) * segments_.size(); }

 private:
  friend std::vector<Cells> levels_of(const Vec3i&, const std::array<bool, 3>&,
                                      const std::vector<std::uint8_t>&, std::uint64_t, const Work&);
  // Numbers the voxels with open[i] != 0 in `index`, 0 for the others.
  Cells(const Vec3i& size, const std::array<bool, 3>& wraps, const std::vector<std::uint8_t>& open,
        std::vector<std::uint32_t>& index, std::uint64_t memory, const Work&);
  std::vector<Segment> segments_of(int z, const std::array<bool, 3>& wraps,
                                   const std::vector<std::uint32_t>& index) const;

  Vec3i size_;
  int seams_ = 0;
  std::size_t length_ = 0;
  std::vector<Segment> segments_;
  std::vector<std::size_t> plane_begin_;
};

// The voxels with open[i] != 0, x fastest, and coarser levels on which 2 × 2 × 2 cells are merged, down to at
// most 4 along each axis. `wraps`: whether the last voxel's neighbor along an axis is the first. Axes have at
// most 65,535 voxels. Throws Error "too-large".
std::vector<Cells> levels_of(const Vec3i& size, const std::array<bool, 3>& wraps,
                             const std::vector<std::uint8_t>& open, std::uint64_t memory, const Work&);

// Of each voxel until levels_of() returns: the phases and masks of its callers, too.
constexpr double kLevelBytes = 9;

// Values of cells at their voxels, and 0 elsewhere. T: float or double.
template <class T>
std::vector<float> of_voxels(const Cells&, const std::vector<T>& values, const Work&);

// Calls visit(z) for z = 0 … planes − 1, on all threads.
template <class Visit>
void each_plane(int planes, std::size_t grain, const Work& work, Visit&& visit) {
  work.quiet().parallel(planes, grain, [&](std::size_t begin, std::size_t end) {
    for (int z = begin, stop = end; z < stop; ++z) visit(z);
  });
}

// Calls visit(segment, z) for each segment, on all threads.
template <class Visit>
void each_segment(const Cells& cells, const Work& work, Visit&& visit) {
  each_plane(cells.size().z(), cells.grain(), work, [&](int z) {
    for (const Segment& s : cells.plane(z)) visit(s, z);
  });
}

// Calls visit(segment, z) for each segment of a finer level, on all threads, of which one handles all parents
// in a plane of the coarser level.
template <class Visit>
void each_child(const Cells& fine, const Cells& coarse, const Work& work, Visit&& visit) {
  each_plane(coarse.size().z(), coarse.grain(), work, [&](int half) {
    for (int z = 2 * half; z < std::min(2 * half + 2, fine.size().z()); ++z)
      for (const Segment& s : fine.plane(z)) visit(s, z);
  });
}

// A sum over all cells of value(segment, i, z) for cell i of the segment, with equal bits on any number of
// threads.
template <class Value>
double sum_over(const Cells& cells, const Work& work, Value&& value) {
  return work.quiet().reduce<double>(
      cells.size().z(), cells.grain(), 0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (int z = begin, stop = end; z < stop; ++z)
          for (const Segment& s : cells.plane(z))
            for (int i = 0; i < s.length; ++i) sum += value(s, i, z);
        return sum;
      },
      [](double a, double b) { return a + b; });
}

}  // namespace terrazzo::homogenize
