// The planes that cut the solid, and the visible window of each.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::section {

// A window in space: the point (x, y) of the section, in mm, is at origin + x·frame.col(0) + y·frame.col(1),
// with 0 ≤ x ≤ width, 0 ≤ y ≤ height; frame is a rotation whose last column is the plane's normal.
struct SectionPlane {
  Mat3 frame = Mat3::Identity();
  Vec3 origin = Vec3::Zero();
};

// All windows of one call have the same size.
struct SectionLayout {
  std::vector<SectionPlane> planes;
  double width = 0, height = 0;  // mm
  bool tile = false;             // the window is one period of the section, with opposite edges joined
  int pixels_x = 0, pixels_y = 0;
  double pixel_size = 0;  // mm

  double window_area() const { return width * height; }
};

struct SectionOptions {
  int planes = 1;
  std::string axis = "z";        // x, y, z, free or random
  std::vector<double> offsets;   // mm along the axis; empty: evenly spaced, half a step from both ends
  Vec3 normal = Vec3::UnitZ();   // of a free plane
  std::optional<Vec3> through;   // mm, the center of a free plane's window; nothing: the box's center
  double width = 0, height = 0;  // mm, of free and random windows; 0: the box's shortest edge
  double pixel_size = 0;         // mm; 0: `default_pixel_size`
  std::uint64_t seed = 1;
};

// Windows through a box with one corner at the origin (edges in mm). Axis windows are parallel to the faces
// of the box and oriented as in slice_axes.h: x shows y to the right and z up, y shows x and z, z shows x and
// y, so that a section of a solid texture looks like the exemplar for its axis. Random windows are isotropic
// uniform random: every orientation and every center in the box is equally likely. A free window has z
// upwards, or, if it is perpendicular to z, y. A given pixel size is rounded so that whole pixels fill the
// width. The default, `default_pixel_size`, is raised if the stack would exceed 64 megapixels. Throws Error
// "bad-offset", "bad-normal", "offsets-at-random", "planes-and-offsets", "too-many-pixels".
SectionLayout choose_planes(const SectionOptions&, const Vec3& box, bool periodic, double default_pixel_size);

}  // namespace terrazzo::section
