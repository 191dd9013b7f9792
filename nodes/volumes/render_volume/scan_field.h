// The densities of a volume as a 16-bit array, for both renderers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/linear.h"
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

// From values, x fastest. Throws Error "too-small" if an edge has fewer than 2 voxels, "bad-values" if a
// value is NaN or infinite, "no-contrast" if all are equal.
ScanField scan_field(const Vec3i& size, const Vec3& spacing, const std::vector<float>& values,
                     const Work& = {});
// From the grid of that name, or from the first grid of one number per voxel if the name is empty. Covers one
// period, or the active voxels. Throws Error "no-grid", "empty-volume", "too-large" (more than 2^31 voxels),
// "tilted-volume", and the errors above.
ScanField scan_field(const Volume&, const std::string& grid, const Work& = {});

}  // namespace terrazzo::render_volume
