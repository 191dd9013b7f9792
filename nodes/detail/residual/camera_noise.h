// The camera's noise in a picture.
#pragma once

#include <Eigen/Dense>

#include <cstdint>
#include <vector>

#include "nodes/data/detail.h"
#include "runtime/work.h"

namespace terrazzo::residual {

// What a camera does to a picture of a plane.
struct Camera {
  double softness = 0;                   // standard deviation of the blur of outlines, mm
  const Detail::Noise* noise = nullptr;  // may be null
  double noise_pixel = 1;                // mm, of the photograph with this noise; larger pixels have less
  std::uint64_t seed = 1;                // of the noise
};

// The camera of the photograph that the detail is from.
Camera camera_of(const Detail&, std::uint64_t seed);

// Rows: lightness times √3 and two axes of chroma, orthonormal, in which noise is measured.
const Eigen::Matrix3f& noise_axes();

// The deviation at a lightness, from those of Detail::Noise; they must not be empty.
float deviation_at(const std::vector<float>& deviations, float lightness);

// Adds noise to scene-linear pixels, row by row from the top. `picture`: its number, so that each has noise
// of its own; `pixel`: mm; `wrap`: opposite edges join.
void add_noise(Vec3f* pixels, int width, int height, double pixel, bool wrap, const Camera&,
               std::uint64_t picture, const Work&);

}  // namespace terrazzo::residual
