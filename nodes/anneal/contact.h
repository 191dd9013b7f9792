// Contact of two bodies on their true surfaces.
#pragma once

#include "nodes/anneal/contact_shape.h"

namespace terrazzo::anneal {

// A placed shape, as the contact code wants it.
struct Body {
  const ContactShape* shape;
  Eigen::Matrix3f rotation;  // own frame to world
  float scale;
};

// What one pair wants of its two bodies. Lengths in mm, world frame.
struct Contact {
  Vec3f push =
      Vec3f::Zero();  // correction of a's position; b's is the opposite. Its length is about the depth
  Vec3f turn_a = Vec3f::Zero(), turn_b = Vec3f::Zero();  // lever × correction, about each centre, mm²
  float lever_a = 0, lever_b = 0;                        // mean squared lever, mm²
  float depth = 0;  // deepest penetration of the margin; 0 where there is none
  float gap = 0;    // where depth is 0: a lower bound of the distance beyond the margin
};

// Elements that may touch while the bodies move no farther than the slack they were collected with: few of
// many, so that most iterations need no search.
struct ContactCandidates {
  std::vector<std::int32_t> of_a, of_b;
  bool known = false;
};

// a's surface against b's field and the other way round. `offset`: b's centre less a's. Surfaces nearer than
// `margin` count as penetrating by the difference. Depths are measured at the elements that enter the margin;
// those that enter deeper count more. `candidates` are probed where known; else they are collected for
// `slack` mm of further travel.
Contact find_contact(const Body& a, const Body& b, const Vec3f& offset, float margin, bool fine,
                     ContactCandidates& candidates, float slack);

}  // namespace terrazzo::anneal
