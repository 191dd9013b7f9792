#include "nodes/common/geometry/camera.h"

#include <algorithm>
#include <cmath>

namespace terrazzo {

Camera Camera::framing(const Eigen::AlignedBox3f& box, float azimuth, float elevation, int width, int height,
                       float field, float fill) {
  Camera c;
  c.forward = -Vec3f(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                     std::sin(elevation));
  c.right = c.forward.cross(Vec3f::UnitZ()).normalized();
  c.up = c.right.cross(c.forward);
  const float shorter = std::tan(field / 2), side = std::min(width, height);
  c.half_width = shorter * float(width) / side;
  c.half_height = shorter * float(height) / side;

  Vec3f target = box.center();
  float distance = 0;
  // Perspective enlarges the near half, so move the target until the projected box is centered.
  for (int pass = 0; pass < 12; ++pass) {
    distance = 0;
    for (int k = 0; k < 8; ++k) {
      const Vec3f v = box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(k)) - target;
      distance = std::max({distance, std::abs(v.dot(c.right)) / (fill * c.half_width) - v.dot(c.forward),
                           std::abs(v.dot(c.up)) / (fill * c.half_height) - v.dot(c.forward)});
    }
    c.position = target - c.forward * distance;
    Eigen::AlignedBox2f seen;
    for (int k = 0; k < 8; ++k) {
      const Vec3f v = box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(k)) - c.position;
      seen.extend(Eigen::Vector2f(v.dot(c.right), v.dot(c.up)) / v.dot(c.forward));
    }
    target += (c.right * seen.center().x() + c.up * seen.center().y()) * distance;
  }
  c.position = target - c.forward * distance;
  return c;
}

}  // namespace terrazzo
