// Sheets at random places: cracks and veins that planes cut into lines.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/detail.h"
#include "nodes/data/linear.h"

namespace terrazzo::residual {

// Disks of random directions with waves, in a box that repeats. Lengths are in pixels of the photograph. An
// isotropic plane cuts disks of diameter d and area S per volume into lines of mean length πd/4, of the
// length πS/4 per area, and of a width that is 4/π times the disks' thickness (Underwood 1970).
class SheetField {
 public:
  SheetField() = default;
  // As dense as Detail::Sheets says, times `most`. `footprint`: edge of the pixels or voxels that show it;
  // larger ones show wider, fainter sheets.
  SheetField(const Vec3& period, const Detail::Sheets&, float most, double footprint, std::uint64_t seed);

  bool empty() const { return sheets_.empty(); }
  // How much a point is of a sheet, 0 to 1, where sheets are `relative` times as dense as Detail::Sheets
  // says, at most `most`.
  float at(const Vec3f& point, float relative) const;

 private:
  struct Sheet {
    Vec3f center, normal, along, across;
    float rank;      // the least relative density at which it is there
    float waves[2];  // phases
  };
  float strength(const Sheet&, Vec3f offset) const;

  Vec3f period_ = Vec3f::Ones();
  Vec3i cells_ = Vec3i::Ones();
  std::vector<std::size_t> first_;  // sheet of each cell, x fastest, and the end
  std::vector<Sheet> sheets_;       // by cell
  float radius_ = 0, width_ = 1, bend_ = 0, share_ = 1;
};

}  // namespace terrazzo::residual
