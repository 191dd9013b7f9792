// Profiles: what plane sections show of the particles.
#pragma once

#include <vector>

#include "nodes/common/linear.h"
#include "runtime/value.h"

namespace terrazzo {

struct Profile {
  int section = 0;
  int cls = 0;                   // colour or particle class, 0…
  double area = 0;               // mm²
  Vec2 centroid = Vec2::Zero();  // mm from the section's lower left corner, y up
  bool touches_border = false;
  // The number of profiles that this one stands for. Border weighting after Miles and Lantuéjoul: 0 where the
  // border cuts it, else window area over the area in which a profile of its extent lies whole.
  double weight = 1;
  Vec3f color = Vec3f::Zero();  // mean, scene-linear
  std::vector<Vec2>
      contour;  // outer outline, mm as the centroid, counter-clockwise, not repeated; may be empty
};

struct Profiles {
  double observed_area = 0;  // mm², all sections together; 0 where unknown (densities then are relative)
  int sections = 1;
  int classes = 1;                     // 1 + the largest Profile::cls
  Vec2 window = Vec2::Zero();          // width and height of one section, mm; zero where unknown
  Vec3f binder_color = Vec3f::Zero();  // mean of all pixels outside profiles, scene-linear
  double area_fraction = 0;            // profiles' pixels / all pixels, border profiles included
  std::vector<Profile> profiles;
};

template <>
const ValueType& value_type<Profiles>();

}  // namespace terrazzo
