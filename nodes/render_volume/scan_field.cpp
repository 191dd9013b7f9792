#include "nodes/render_volume/scan_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"

namespace terrazzo::render_volume {

ScanField scan_field(const Vec3i& size, const Vec3& spacing, const std::vector<float>& values,
                     const Work& work) {
  if (size.minCoeff() < 2)
    throw Error("too-small",
                fmt::format("the volume is {} × {} × {} voxels, and between voxels is where a ray looks",
                            size.x(), size.y(), size.z()),
                "give at least 2 along each axis");
  ScanField f;
  f.size = size, f.spacing = spacing.cast<float>();
  float low = values[0], high = values[0];
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i % (1u << 22) == 0) work.check();
    if (!std::isfinite(values[i])) {
      const auto nx = static_cast<std::size_t>(size.x()), ny = static_cast<std::size_t>(size.y());
      throw Error("bad-values",
                  fmt::format("voxel ({}, {}, {}) is no finite number", i % nx, i / nx % ny, i / nx / ny),
                  "replace NaN and infinity before");
    }
    low = std::min(low, values[i]), high = std::max(high, values[i]);
  }
  if (!(high > low))
    throw Error("no-contrast", fmt::format("all voxels are {}", low), "there is nothing to see in it");
  // Whole numbers stay exact where they fit, as those of scanners do.
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
