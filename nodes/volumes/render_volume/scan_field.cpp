#include "nodes/volumes/render_volume/scan_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"

namespace terrazzo::render_volume {

ScanField scan_field(const Vec3i& size, const Vec3& spacing, const std::vector<float>& values,
                     const Work& work) {
  if (size.minCoeff() < 2)
    throw Error("too-small",
                fmt::format("the volume has {} × {} × {} voxels, too few to interpolate", size.x(), size.y(),
                            size.z()),
                "use at least 2 voxels along each axis");
  ScanField f;
  f.size = size;
  f.spacing = spacing.cast<float>();
  float low = values[0], high = values[0];
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i % (1u << 22) == 0) work.check();
    if (!std::isfinite(values[i])) {
      const std::size_t nx = size.x(), ny = size.y();
      throw Error("bad-values",
                  fmt::format("voxel ({}, {}, {}) is NaN or infinite", i % nx, i / nx % ny, i / nx / ny),
                  "replace NaN and infinity before this node");
    }
    low = std::min(low, values[i]);
    high = std::max(high, values[i]);
  }
  if (!(high > low))
    throw Error("no-contrast", fmt::format("all voxels are {}", low),
                "connect a volume with varying densities");
  // Integers stay exact if they fit, as scanner values do.
  f.low = std::floor(low);
  f.step = (high - f.low) / 65535;
  if (high - f.low <= 65535 && high - low >= 64) f.step = 1.0f / std::floor(65535 / (high - f.low));
  f.voxels.resize(values.size());
  work.parallel(values.size(), 1u << 18, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      f.voxels[i] = static_cast<std::uint16_t>(std::clamp(f.stored(values[i]) + 0.5f, 0.0f, 65535.0f));
  });
  return f;
}

}  // namespace terrazzo::render_volume
