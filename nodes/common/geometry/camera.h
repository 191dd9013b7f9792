// Perspective camera that frames a box.
#pragma once

#include "nodes/data/linear.h"

namespace terrazzo {

struct Camera {
  Vec3f position, forward, right, up;     // unit vectors; up and right in the image
  float half_width = 0, half_height = 0;  // of the image plane at distance 1

  // Looks at the box from `azimuth` (radians from +x towards +y) and `elevation`. The box is centered and
  // fills the fraction `fill` of the tighter side of the image. `field` is the angle of view over the shorter
  // side, in radians.
  static Camera framing(const Eigen::AlignedBox3f& box, float azimuth, float elevation, int width, int height,
                        float field = 0.38f, float fill = 0.8f);

  // Direction through a point of the image, given in pixels from the top left corner.
  Vec3f direction(float x, float y, int width, int height) const {
    return (forward + right * ((2 * x / float(width) - 1) * half_width) +
            up * ((1 - 2 * y / float(height)) * half_height))
        .normalized();
  }
  // Projects a point in front of the camera to pixels.
  Eigen::Vector2f project(const Vec3f& p, int width, int height) const {
    const Vec3f v = p - position;
    const float depth = v.dot(forward);
    return {(v.dot(right) / depth / half_width + 1) * 0.5f * float(width),
            (1 - v.dot(up) / depth / half_height) * 0.5f * float(height)};
  }
};

}  // namespace terrazzo
