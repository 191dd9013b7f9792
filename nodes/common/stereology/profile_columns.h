// What tables of profiles say of each outline.
#pragma once

#include <string>
#include <vector>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/data/image.h"
#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo {

struct ProfileColumn {
  std::string name;            // "major_axis"
  int power = 0;               // 1: a length in mm, 2: an area in mm², 0: without a unit of length
  std::vector<double> values;  // one per profile; NaN if its outline is unknown
};

// equivalent_diameter, and if any outline is known, the fields of OutlineMeasures.
std::vector<ProfileColumn> profile_columns(const Profiles&, const Work& = {});

// Mean of the pixels inside of each outline, scene-linear; NaN without any. Throws Error "size-mismatch" if
// the profiles are not of this picture.
std::vector<Vec3f> mean_colors(const Profiles&, const Image&, const Work& = {});

// Throws Error "size-mismatch" if a picture of this size cannot be the profiles'. An unknown window fits any
// picture.
void require_picture(const Profiles&, int width, int height, int sections, double pixel_size);

// An outline in pixels from the upper left corner, y down. The order of its points is reversed, so that its
// area stays positive.
Loop in_pixels(const std::vector<Vec2>& contour, double pixel_size, int height);

}  // namespace terrazzo
