#include "nodes/detail/residual/picture_detail.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/detail/residual/outline_depth.h"
#include "nodes/detail/residual/residual_field.h"

namespace terrazzo::residual {

void add_to_picture(Vec3f* pixels, const PicturePlane& plane, std::span<const std::int32_t> ids,
                    std::span<const std::int32_t> owner, std::span<const float> cover,
                    const ResidualField& detail, const Work& work) {
  const Outlines outlines = nearest_outlines(ids.data(), plane.width, plane.height, plane.wrap);
  const std::vector<float> sizes = sizes_of_particles(ids, std::sqrt(plane.mm_x * plane.mm_y));
  const float pixel = plane.mm_x;
  const Vec3f right = plane.right.cast<float>(), up = plane.up.cast<float>();
  const Vec3 normal = plane.right.cross(plane.up);
  work.quiet().parallel(plane.height, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      for (int x = 0; x < plane.width; ++x) {
        const std::size_t at = row * static_cast<std::size_t>(plane.width) + x;
        const double u = (x + 0.5) * plane.mm_x,
                     v = (plane.height - static_cast<double>(row) - 0.5) * plane.mm_y;
        Vec3 point = plane.origin + u * plane.right + v * plane.up;
        if (!plane.above.empty()) point += double{plane.above[at]} * normal;
        const Vec3f mm = point.cast<float>();
        const float share = std::min(cover[at], 1.0f), depth = outlines.depth[at] * pixel,
                    size = sizes[outlines.particle[at]];
        const Vec3f offset = detail.mixed(mm, owner[at], share, depth, size) +
                             detail.light(mm, owner[at], share, depth, size, outlines.normal[at], right, up);
        pixels[at] = srgb_to_linear((linear_to_srgb(pixels[at]) + offset).cwiseMax(0.0f));
      }
  });
}

}  // namespace terrazzo::residual
