// Distances to the outlines of labels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::residual {

struct Outlines {
  // From the center of each pixel to the nearest outline between different ids, pixels; at least 0.5.
  std::vector<float> depth;
  // The particle with that outline: the pixel's own id, or, where this is 0, the id on its other side. 0 in a
  // picture without outlines and particles.
  std::vector<std::int32_t> particle;
  // The outward normal of that outline, to the right and upwards in the picture: of length 1, and shorter
  // where outlines on several sides are about equally near, so that it changes smoothly. Zero without
  // outlines.
  std::vector<Eigen::Vector2f> normal;
};

// `ids`: 0 outside of particles. `wrap`: opposite edges of the picture join. Pictures without outlines have
// distances of at least their diagonal.
Outlines nearest_outlines(const std::int32_t* ids, int width, int height, bool wrap);

// How wide the binder is at each of its pixels: the radius, in pixels, of the largest disk within it that
// covers the pixel (local thickness: Hildebrand, Rüegsegger 1997), up to 64 units, smoothed over four units
// and continued a few into particles; 0 deeper in them. `ids` and `wrap` as above; `unit`: of the
// photograph's pixels, in pixels of this picture.
std::vector<float> binder_width(const std::int32_t* ids, int width, int height, bool wrap, double unit = 1,
                                const Work& = {});

// √(4A/π) of the particle of each id, from its pixels; 0 for id 0. `pixel`: root of a pixel's area, in the
// unit of the sizes.
std::vector<float> sizes_of_particles(std::span<const std::int32_t> ids, double pixel);

// Only the distances.
std::vector<float> outline_depth(const std::int32_t* ids, int width, int height, bool wrap);

}  // namespace terrazzo::residual
