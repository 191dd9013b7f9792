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

// What contact points want of one body, as the normal equations of a least squares problem: at each point the
// body should move by `depth` along the unit normal n, which displacement x and turn w do by J·(x, w), J =
// (n, arm × n). Sums of weight·J·Jᵀ (upper triangle by rows) and weight·J·depth, in mm and world directions.
struct Demand {
  float square[21] = {};
  float side[6] = {};
  void add(const Vec3f& n, const Vec3f& arm, float depth, float weight);
  void scale(float factor);
};

// What one pair wants of its two bodies; the weights of its points sum to 1.
struct Contact {
  Demand a, b;
  float weight = 0;  // while points are added
  float depth = 0;   // deepest penetration of the margin, mm; 0 where there is none
  float gap = 0;     // where depth is 0: a lower bound of the distance beyond the margin, mm
  // n parts a from b: it points from b to a. Arms are from each centre. `push` is how far to move, `depth`
  // how far the point is inside the margin.
  void add(const Vec3f& n, const Vec3f& arm_a, const Vec3f& arm_b, float depth, float push);
};

// Elements that may touch while the bodies move no farther than the slack they were collected with: few of
// many, so that most iterations need no search.
struct ContactCandidates {
  std::vector<std::int32_t> of_a, of_b;
  bool known = false;
  Vec3f axis = Vec3f::Zero();  // of polyhedra: that which parted them last
};

// a's surface against b's field and the other way round. `offset`: b's centre less a's. Surfaces nearer than
// `margin` count as penetrating by the difference. Depths are measured at the elements that enter the margin;
// those that enter deeper count more. `candidates` are probed where known; else they are collected for
// `slack` mm of further travel.
Contact find_contact(const Body& a, const Body& b, const Vec3f& offset, float margin, Detail detail,
                     ContactCandidates& candidates, float slack);

}  // namespace terrazzo::anneal
