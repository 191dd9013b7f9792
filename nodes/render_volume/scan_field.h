// The densities of a volume as an array, in 16 bit: what both renderers read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/work.h"

namespace terrazzo {
struct Volume;
}

namespace terrazzo::render_volume {

struct ScanField {
  Vec3i size = Vec3i::Zero();
  Vec3f spacing = Vec3f::Ones();      // mm
  float low = 0, step = 1;            // density = low + step · stored
  std::vector<std::uint16_t> voxels;  // x fastest

  float stored(float density) const { return (density - low) / step; }
  Vec3f extent() const { return size.cast<float>().cwiseProduct(spacing); }  // mm
};

// From numbers, x fastest. Throws Error "too-small" where an edge has fewer than 2 voxels, "bad-values" where
// one is NaN or infinite, "no-contrast" where all are equal.
ScanField scan_field(const Vec3i& size, const Vec3& spacing, const std::vector<float>& values,
                     const Work& = {});
// The grid of that name, or the first of one number a voxel where it is empty; over one period, or the active
// voxels. Throws Error "no-grid", "empty-volume", "too-large" (more than 2^31 voxels), "tilted-volume", and
// the above.
ScanField scan_field(const Volume&, const std::string& grid, const Work& = {});

}  // namespace terrazzo::render_volume
