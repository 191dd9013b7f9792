// Profiles: profiles of particles in plane sections.
#pragma once

#include <vector>

#include "nodes/data/linear.h"
#include "runtime/value.h"

namespace terrazzo {

// What a photograph shows of the particles.
enum class View {
  Section,  // a plane cut through particles in a binder
  Surface,  // whole particles seen from outside, which hide each other
  Filling   // a plane cut through particles that meet without a binder
};
inline constexpr View kViews[] = {View::Section, View::Surface, View::Filling};

struct Profile {
  int section = 0;
  int cls = 0;                   // color or particle class, from 0
  double area = 0;               // mm²
  Vec2 centroid = Vec2::Zero();  // mm from the section's lower left corner, y up
  bool touches_border = false;
  // Number of profiles that this one represents. Border correction after Miles and Lantuéjoul: 0 if the
  // profile touches the border, otherwise the window area divided by the area of the positions in which a
  // profile of this extent lies completely inside.
  double weight = 1;
  double confidence = 1;        // how likely it is one particle, outlined correctly; 1 if nobody judged
  Vec3f color = Vec3f::Zero();  // median of each channel, scene-linear
  std::vector<Vec2> contour;    // outer outline, mm like the centroid, counterclockwise, first point not
                                // repeated; may be empty
  // In View::Surface, the area of the particle's silhouette as if nothing hid it, estimated from the visible
  // part, mm² (common/stereology/silhouette.h); otherwise 0.
  double whole = 0;
};

// A part of a particle whose outline is unknown.
struct Fragment {
  Vec3f color = Vec3f::Zero();  // median of each channel, scene-linear
  double area = 0;              // mm²
};

struct Profiles {
  double observed_area = 0;  // mm², total of all sections; 0: unknown (densities are then relative)
  int sections = 1;
  int classes = 1;                     // largest Profile::cls + 1
  Vec2 window = Vec2::Zero();          // width and height of one section, mm; 0: unknown
  Vec3f binder_color = Vec3f::Zero();  // mean of all pixels outside profiles, scene-linear
  double area_fraction = 0;            // pixels in profiles / all pixels, including border profiles
  std::vector<Profile> profiles;
  std::vector<Fragment> fragments;  // outside of observed_area
  View view = View::Section;
  // In View::Surface, how fast the logarithm of the luminance grows across a particle, per radius, to the
  // right and upwards: it points toward the light. Otherwise 0.
  Vec2 light = Vec2::Zero();
};

// Whether the profiles show stones that lie on each other, without soil between them: of a surface whose gaps
// are shadows, darker than `kShadow` of the stones, or that stones cover by `kLooseCover`: those in soil
// leave more of it free, since none lie on others.
inline constexpr float kShadow = 0.6F;
inline constexpr double kLooseCover = 0.8;
bool shows_loose_stones(const Profiles&);

// "section", "surface" or "filling".
const char* name_of(View);

template <>
const ValueType& value_type<Profiles>();

}  // namespace terrazzo
