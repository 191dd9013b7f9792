// Contact of two bodies on their true surfaces.
#pragma once

#include "nodes/packing/rigid/contact/contact_shape.h"

namespace terrazzo::packing {

// A placed shape, in the form that the contact code needs.
struct Body {
  const ContactShape* shape;
  Eigen::Matrix3f rotation;  // own frame to world
  float scale;
};

// The motion that contact points require of one body, as the normal equations of a least-squares problem.
// At each point the body should move by `depth` along the unit normal n; displacement x and rotation w
// move it by J·(x, w), J = (n, arm × n). Sums of weight·J·Jᵀ (upper triangle by rows) and weight·J·depth,
// in mm and world directions.
struct Demand {
  float square[21] = {};
  float side[6] = {};
  void add(const Vec3f& n, const Vec3f& arm, float depth, float weight);
  void scale(float factor);
};

// The motions that one pair requires of its two bodies; the weights of its points sum to 1.
struct Contact {
  Demand a, b;
  float weight = 0;  // sum of weights while points are added
  float depth = 0;   // deepest penetration of the margin, mm; 0 if there is none
  float gap = 0;     // if depth is 0, a lower bound of the distance beyond the margin, mm
  int tests = 0;     // work done: samples of a distance field, or as much arithmetic
  // n points from b to a, the direction in which a must move. Arms start at each body's center. `push` is the
  // required motion, `depth` how far the point is inside the margin.
  void add(const Vec3f& n, const Vec3f& arm_a, const Vec3f& arm_b, float depth, float push);
};

// Elements that may touch while the bodies move no farther than the slack with which they were collected.
// They are few, so that most iterations need no search.
struct ContactCandidates {
  std::vector<std::int32_t> of_a, of_b;
  bool known = false;
  Vec3f axis = Vec3f::Zero();  // for polyhedra: the last separating axis
};

// Tests a's surface against b's field and vice versa. `offset` is b's center minus a's. Surfaces closer than
// `margin` penetrate by the difference. Depths are measured at the elements inside the margin, weighted by
// depth. Tests only `candidates` if they are known; otherwise collects them for `slack` mm of further motion.
Contact find_contact(const Body& a, const Body& b, const Vec3f& offset, float margin, ContactDetail detail,
                     ContactCandidates& candidates, float slack);

}  // namespace terrazzo::packing
