#include "nodes/bodies/cutting/planes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/directions.h"
#include "nodes/common/geometry/grid/slice_axes.h"
#include "runtime/random.h"

namespace terrazzo::section {

namespace {

void lay_pixels(SectionLayout& layout, double wanted, double fallback) {
  constexpr double kMost = 64e6, kLimit = 256e6;
  const double sections = layout.planes.size();
  if (wanted <= 0) wanted = std::max(fallback, std::sqrt(layout.window_area() * sections / kMost));
  const double x = std::max(1.0, std::round(layout.width / wanted));
  const double y = std::max(1.0, std::round(layout.height / (layout.width / x)));
  if (!(x * y * sections <= kLimit))
    throw Error("too-many-pixels",
                fmt::format("{} sections of {:.0f} × {:.0f} pixels exceed the limit of {:.0f} megapixels",
                            sections, x, y, kLimit / 1e6),
                "raise pixel_size or use fewer planes")
        .parameter("pixel_size");
  layout.pixels_x = static_cast<int>(x);
  layout.pixels_y = static_cast<int>(y);
  layout.pixel_size = layout.width / x;
}

// Columns: to the right, upwards, and the normal.
Mat3 frame_of(const Vec3& normal) {
  if (!(normal.norm() > 1e-9) || !normal.allFinite())
    throw Error("bad-normal", "the plane's normal has no direction", "set three numbers that are not all 0")
        .parameter("normal");
  Mat3 frame;
  frame.col(2) = normal.normalized();
  const Vec3 up = std::abs(frame(2, 2)) < 1 - 1e-9 ? Vec3::UnitZ() : Vec3::UnitY();
  frame.col(0) = up.cross(frame.col(2)).normalized();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

}  // namespace

SectionLayout choose_planes(const SectionOptions& choice, const Vec3& box, bool periodic,
                            double default_pixel_size) {
  SectionLayout layout;
  if (choice.axis == "random" || choice.axis == "free") {
    if (!choice.offsets.empty())
      throw Error("offsets-at-random", fmt::format("offsets do not apply to {} planes", choice.axis),
                  "set axis to x, y or z, or offsets to auto")
          .parameter("offsets");
    layout.width = choice.width > 0 ? choice.width : box.minCoeff();
    layout.height = choice.height > 0 ? choice.height : box.minCoeff();
    const auto add = [&](const Mat3& frame, const Vec3& center) {
      layout.planes.push_back(
          {frame, center - frame.col(0) * (layout.width / 2) - frame.col(1) * (layout.height / 2)});
    };
    if (choice.axis == "free") add(frame_of(choice.normal), choice.through.value_or(box / 2));
    for (int i = 0; choice.axis == "random" && i < choice.planes; ++i) {
      Random random(choice.seed, 0x73656374, static_cast<std::uint64_t>(i));
      const Mat3 frame = random_rotation(random).normalized().toRotationMatrix();
      Vec3 center;
      for (int k = 0; k < 3; ++k) center[k] = box[k] * random.uniform();
      add(frame, center);
    }
  } else {
    const int u = choice.axis[0] - 'x';
    const int a = kSliceColumns[u], b = kSliceRows[u];
    layout.width = box[a];
    layout.height = box[b];
    layout.tile = periodic;
    const auto given = choice.offsets.size();
    if (given > 1 && choice.planes > 1 && given != static_cast<std::size_t>(choice.planes))
      throw Error("planes-and-offsets",
                  fmt::format("planes is {}, but there are {} offsets", choice.planes, given),
                  "set only one of planes and offsets")
          .parameter("offsets");
    const auto n = given ? given : static_cast<std::size_t>(choice.planes);
    for (std::size_t i = 0; i < n; ++i) {
      SectionPlane plane;
      plane.frame.col(0) = Vec3::Unit(a);
      plane.frame.col(1) = Vec3::Unit(b);
      plane.frame.col(2) = plane.frame.col(0).cross(plane.frame.col(1));
      const double offset = given ? choice.offsets[i] : (i + 0.5) * box[u] / n;
      if (!(offset >= 0 && offset <= box[u]))
        throw Error("bad-offset",
                    fmt::format("the plane at {} = {:g} mm misses the box, which ends at {:g} mm",
                                choice.axis, offset, box[u]),
                    fmt::format("offsets must be within 0 … {:g} mm", box[u]))
            .parameter("offsets");
      plane.origin = offset * Vec3::Unit(u);
      layout.planes.push_back(plane);
    }
  }
  lay_pixels(layout, choice.pixel_size, default_pixel_size);
  return layout;
}

}  // namespace terrazzo::section
