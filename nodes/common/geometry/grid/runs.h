// Runs of voxels of one label, joined where they touch by faces of voxels (6 neighbors).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "runtime/work.h"

namespace terrazzo {

// Voxels [begin, end) of a row along x that have one label.
struct VoxelRun {
  std::int32_t label;
  int begin, end;
};

class VoxelRuns {
 public:
  // Of labels that are not negative, x fastest. Periodic boxes wrap.
  template <class Label>
  VoxelRuns(const Label* labels, const VoxelBox& box, const Work& work)
      : size_(box.size), wraps_(box.periodic) {
    row_begin.push_back(0);
    for (int z = 0; z < size_.z(); ++z) {
      work.check();
      for (int y = 0; y < size_.y(); ++y) add_row(labels + voxel_at(0, y, z, size_));
    }
    join(work);
  }

  std::vector<VoxelRun> runs;
  std::vector<std::size_t> row_begin;  // first run of each row, + 1

  // The first run of the piece that contains run k.
  std::size_t root(std::size_t k);
  // Along which axes (bits 0 to 2) some path inside the piece of this root leads through the period back to
  // where it began, but in another period. 0 if the box does not wrap.
  unsigned winding(std::size_t root) const { return winding_[root]; }
  // The axes along which each piece reaches across (bits 0 to 2), at its root: those of its winding, or if
  // the box does not wrap, those of which it touches both opposite sides.
  std::vector<std::uint8_t> reach(const Work&);

 private:
  using Periods = std::array<std::int32_t, 3>;

  Vec3i size_;
  bool wraps_;
  std::vector<std::size_t> parent_;
  std::vector<Periods> offset_;        // periods from the parent to the run, on a path inside the piece
  std::vector<std::uint8_t> winding_;  // of roots

  template <class Label>
  void add_row(const Label* labels) {
    for (int x = 0; x < size_.x();) {
      const int begin = x;
      while (x < size_.x() && labels[x] == labels[begin]) ++x;
      if (const std::int32_t label = labels[begin]; label >= 0) runs.push_back({label, begin, x});
    }
    row_begin.push_back(runs.size());
  }

  std::size_t row(int y, int z) const { return static_cast<std::size_t>(z) * size_.y() + y; }
  void join(const Work& work);
  void join_ends(std::size_t r);
  void join_rows(std::size_t r, std::size_t s, const Periods& step);
  // `step`: periods from a to b, which touch.
  void unite(std::size_t a, std::size_t b, const Periods& step);
};

}  // namespace terrazzo
