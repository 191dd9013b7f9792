#include "nodes/packing/rigid/contact/contact.h"

#include <algorithm>
#include <cmath>

#include "nodes/packing/rigid/contact/polytope_contact.h"

namespace terrazzo::packing {
namespace {

constexpr float kAlongCenters = 0.15f;  // share of the push along the line between the centers

// Contacts of one body's elements in the field of the other: points in the field's frame and unit.
struct Probe {
  struct Point {
    Vec3f p, n;
    float depth, push;
  };
  std::vector<Point>& points;
  float weight = 0, gap = 1e30f;
  int tests = 0;  // samples of the field
};

struct Frame {  // maps the elements' frame to that of the field
  float m[9];
  Vec3f t;
  float scale;
  void point(const float* p, float* q) const {
    for (int r = 0; r < 3; ++r) q[r] = m[3 * r] * p[0] + m[3 * r + 1] * p[1] + m[3 * r + 2] * p[2] + t[r];
  }
  void direction(const float* p, float* q) const {
    for (int r = 0; r < 3; ++r) q[r] = m[3 * r] * p[0] + m[3 * r + 1] * p[1] + m[3 * r + 2] * p[2];
  }
};

// `depth`: how far p is inside the margin. `push`: how far it must move along n to leave it.
void add(Probe& probe, const Vec3f& p, const Vec3f& n, float depth, float push) {
  probe.weight += depth;
  probe.points.push_back({p, n, depth, push});
}

// The lowest point of the field along a segment, found by intersecting the tangents at the two ends (Kelley's
// cutting planes in one dimension): finite for the planes of a polyhedron, and close for a grid. Returns a
// lower bound of the field.
float probe_segment(Probe& probe, const Frame& frame, const DistanceField& field, const Element& e,
                    float threshold) {
  float c[3], h[3], g[3];
  frame.point(e.center, c);
  frame.direction(e.half, h);
  const float length = e.half_length * frame.scale;
  const float middle = field.value(c);
  ++probe.tests;
  if (middle - length > threshold) {
    probe.gap = std::min(probe.gap, middle - length);
    return middle - length;
  }
  struct End {
    float at, value, slope;
    Vec3f p, n;
  };
  const auto sample = [&](float at) {
    ++probe.tests;
    End end;
    end.at = at;
    for (int a = 0; a < 3; ++a) end.p[a] = c[a] + at * h[a];
    end.value = field.value(end.p.data(), g);
    end.n = Vec3f(g[0], g[1], g[2]);
    end.slope = g[0] * h[0] + g[1] * h[1] + g[2] * h[2];
    return end;
  };
  End lo = sample(-1), hi = sample(1);
  End best = lo.value <= hi.value ? lo : hi;
  float bound = best.value;
  const bool convex = field.kind() != DistanceField::Kind::Grid;  // otherwise the tangents are no bound
  for (int step = 0; step < 6 && lo.slope < 0 && hi.slope > 0; ++step) {
    // Intersection of the two tangents: the smallest possible value of a convex function there.
    const float at = (hi.value - lo.value + lo.slope * lo.at - hi.slope * hi.at) / (lo.slope - hi.slope);
    if (!(at > lo.at && at < hi.at)) break;
    bound = lo.value + lo.slope * (at - lo.at);
    if (convex && bound > threshold) break;
    const End mid = sample(at);
    if (mid.value < best.value) best = mid;
    if (mid.value - bound < 1e-3f * length || step == 5) {
      if (mid.value < threshold) {
        // At a ridge the segment leaves across it: mix the normals of both faces.
        best = mid;
        const float s = hi.slope / (hi.slope - lo.slope);
        best.n = s * lo.n + (1 - s) * hi.n;
      }
      break;
    }
    (mid.slope < 0 ? lo : hi) = mid;
  }
  if (best.value >= threshold) {
    const float low = std::max(convex ? std::min(bound, best.value) : best.value, threshold);
    probe.gap = std::min(probe.gap, low);
    return low;
  }
  const float depth = threshold - best.value;
  float norm = best.n.norm();
  if (norm < 0.3f) {  // the segment passes through the whole body: no face is the right one to leave by
    best.n = frame.t;
    norm = best.n.norm();
    if (!(norm > 1e-6f)) {
      best.n = Vec3f(1, 0, 0);
      norm = 1;
    }
    best.n /= norm;
    norm = 1;
  } else {
    best.n /= norm;
  }
  add(probe, best.p, best.n, depth, depth / std::clamp(norm, 0.5f, 1.f));
  return best.value;
}

// Returns a lower bound of the field at the element.
float probe_element(Probe& probe, const Frame& frame, const DistanceField& field, const Element& e,
                    float threshold) {
  if (e.half_length > 0) return probe_segment(probe, frame, field, e, threshold);
  float c[3], g[3];
  frame.point(e.center, c);
  const float v = field.value(c, g);
  ++probe.tests;
  if (v >= threshold) {
    probe.gap = std::min(probe.gap, v);
    return v;
  }
  Vec3f n(g[0], g[1], g[2]);
  const float norm = n.norm();
  if (norm > 1e-6f) n /= norm;
  add(probe, Vec3f(c[0], c[1], c[2]), n, threshold - v, threshold - v);
  return v;
}

// Only a ball whose center is inside counts, because outside the field may be less than the distance.
void probe_ball(Probe& probe, const Frame& frame, const ContactShape& other, const Ball& ball) {
  const DistanceField& field = other.field;
  float c[3], g[3];
  frame.point(ball.center, c);
  const float far = other.bounding_radius;
  if (c[0] * c[0] + c[1] * c[1] + c[2] * c[2] > far * far) return;
  const float v = field.value(c, g);
  ++probe.tests;
  if (v >= 0) return;
  Vec3f n(g[0], g[1], g[2]);
  const float norm = n.norm();
  if (norm > 1e-6f) n /= norm;
  const float depth = ball.radius * frame.scale - v;
  add(probe, Vec3f(c[0], c[1], c[2]), n, depth, depth);
}

// Tests all elements below `threshold` through the tree; lists those below `keep` in `noted`.
Probe probe_tree(const ElementTree& tree, const Frame& frame, const DistanceField& field, float threshold,
                 float keep, std::vector<std::int32_t>& noted, std::vector<Probe::Point>& points) {
  Probe probe{points};
  noted.clear();
  const auto* nodes = tree.nodes.data();
  const std::int32_t end = tree.nodes.size();
  for (std::int32_t k = 0; k < end;) {
    const auto& node = nodes[k];
    float c[3];
    frame.point(node.center, c);
    ++probe.tests;
    const float clearance = field.value(c) - node.radius * frame.scale;
    if (clearance > keep) {
      probe.gap = std::min(probe.gap, clearance);
      k = node.next;
      continue;
    }
    for (int m = node.first; m < node.first + node.count; ++m)
      if (probe_element(probe, frame, field, tree.elements[m], threshold) < keep) noted.push_back(m);
    ++k;
  }
  return probe;
}

// Tests the elements of `own` in the field of `other`. `offset` is other's center minus own's.
Probe probe_body(const Body& own, const Body& other, const Vec3f& offset, float margin, ContactDetail detail,
                 float slack, bool known, std::vector<std::int32_t>& candidates,
                 std::vector<Probe::Point>& points) {
  points.clear();
  Frame frame;
  const float inverse = 1 / other.scale;
  frame.scale = own.scale * inverse;
  const Eigen::Matrix3f m = other.rotation.transpose() * own.rotation * frame.scale;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) frame.m[3 * r + c] = m(r, c);
  frame.t = other.rotation.transpose() * (-offset) * inverse;
  const ElementTree& tree = own.shape->tree(detail);
  const float threshold = margin * inverse;
  Probe probe{points};
  if (known) {
    for (std::int32_t e : candidates)
      probe_element(probe, frame, other.shape->field, tree.elements[e], threshold);
  } else {
    const Probe found = probe_tree(tree, frame, other.shape->field, threshold, threshold + slack * inverse,
                                   candidates, points);
    probe.weight = found.weight;
    probe.gap = found.gap;
    probe.tests = found.tests;
  }
  if (probe.weight > 0)
    for (const Ball& ball : own.shape->core) probe_ball(probe, frame, *other.shape, ball);
  return probe;
}

// Adds a probe to the contact.
void accumulate(Contact& contact, const Probe& probe, const Body& field, const Vec3f& offset,
                bool elements_are_a) {
  const float s = field.scale;
  for (const auto& q : probe.points) {
    const Vec3f arm = field.rotation * (q.p * s), n = field.rotation * q.n;
    if (elements_are_a)  // the field is b's: n points out of b
      contact.add(n, arm + offset, arm, q.depth * s, q.push * s);
    else
      contact.add(-n, arm, arm - offset, q.depth * s, q.push * s);
  }
}

Contact finished(Contact contact) {
  if (contact.weight > 0) {
    contact.a.scale(1 / contact.weight);
    contact.b.scale(1 / contact.weight);
  }
  return contact;
}

Contact contact_of_polytopes(const Body& a, const Body& b, const Vec3f& offset, float margin, Vec3f& axis) {
  Contact contact;
  Manifold manifold;
  find_manifold({&a.shape->polytope, a.rotation, a.scale}, {&b.shape->polytope, b.rotation, b.scale}, offset,
                margin, axis, manifold);
  for (int k = 0; k < manifold.count; ++k) {
    const ContactPoint& q = manifold.points[k];
    if (q.depth > 0) contact.add(-manifold.normal, q.p, q.p - offset, q.depth, q.depth);
  }
  contact.tests = manifold.tests;
  if (contact.depth == 0) contact.gap = std::max(manifold.separation - margin, 0.f);
  return finished(contact);
}

}  // namespace

void Demand::add(const Vec3f& n, const Vec3f& arm, float depth, float weight) {
  const Vec3f c = arm.cross(n);
  const float j[6] = {n[0], n[1], n[2], c[0], c[1], c[2]};
  int at = 0;
  for (int r = 0; r < 6; ++r) {
    const float w = weight * j[r];
    side[r] += w * depth;
    for (int k = r; k < 6; ++k) square[at++] += w * j[k];
  }
}

void Demand::scale(float factor) {
  for (float& v : square) v *= factor;
  for (float& v : side) v *= factor;
}

void Contact::add(const Vec3f& n, const Vec3f& arm_a, const Vec3f& arm_b, float d, float push) {
  a.add(n, arm_a, push, d);
  b.add(-n, arm_b, push, d);
  weight += d;
  depth = std::max(depth, d);
}

Contact find_contact(const Body& a, const Body& b, const Vec3f& offset, float margin, ContactDetail detail,
                     ContactCandidates& candidates, float slack) {
  Contact contact;
  const bool ball_a = a.shape->field.kind() == DistanceField::Kind::Sphere;
  const bool ball_b = b.shape->field.kind() == DistanceField::Kind::Sphere;
  if (ball_a && ball_b) {
    const float distance = offset.norm();
    const float gap = distance - static_cast<float>(a.shape->ball) * a.scale -
                      static_cast<float>(b.shape->ball) * b.scale - margin;
    if (gap >= 0) {
      contact.gap = gap;
      return contact;
    }
    const Vec3f n = distance > 1e-12f ? Vec3f(-offset / distance) : Vec3f(1, 0, 0);
    contact.add(n, Vec3f::Zero(), Vec3f::Zero(), -gap, -gap);
    return finished(contact);
  }
  if (!a.shape->polytope.empty() && !b.shape->polytope.empty())
    return contact_of_polytopes(a, b, offset, margin, candidates.axis);

  const bool known = candidates.known;
  candidates.known = true;
  thread_local std::vector<Probe::Point> points_a, points_b;
  const Probe of_a = probe_body(a, b, offset, margin, detail, slack, known, candidates.of_a, points_a);
  const float gap_a = of_a.gap * b.scale - margin;
  if (!known && of_a.weight == 0 && gap_a > 0.5f * a.scale * static_cast<float>(a.shape->gyration)) {
    candidates.known = false;
    contact.tests = of_a.tests;
    contact.gap = gap_a;  // so far apart that the other direction cannot find a contact either
    return contact;
  }
  const Probe of_b = probe_body(b, a, -offset, margin, detail, slack, known, candidates.of_b, points_b);
  contact.tests = of_a.tests + of_b.tests + static_cast<int>(points_a.size() + points_b.size());
  if (of_a.weight == 0 && of_b.weight == 0) {
    contact.gap = std::max(std::min(gap_a, of_b.gap * a.scale - margin), 0.f);
    return contact;
  }
  accumulate(contact, of_a, b, offset, true);
  accumulate(contact, of_b, a, offset, false);
  // Surfaces of bodies deep inside each other push in all directions, and crossed edges may push back
  // and forth. Therefore a share of the push, and nearly all of it for deep overlaps, is along the
  // line between the centers.
  const float deep = 0.35f * std::min(a.scale * static_cast<float>(a.shape->gyration),
                                      b.scale * static_cast<float>(b.shape->gyration));
  const float distance = offset.norm();
  if (distance > 1e-12f) {
    const float mix = std::clamp(contact.depth / deep - 1, kAlongCenters, 0.95f);
    const float weight = contact.weight * mix / (1 - mix), depth = contact.depth;
    const Vec3f n = -offset / distance;
    contact.a.add(n, Vec3f::Zero(), depth, weight);
    contact.b.add(-n, Vec3f::Zero(), depth, weight);
    contact.weight += weight;
  }
  return finished(contact);
}

}  // namespace terrazzo::packing
