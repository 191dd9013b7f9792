#include "nodes/packing/rigid/contact/polytope_contact.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::packing {
namespace {

struct Best {
  float separation = -1e30f;
  Vec3f axis = Vec3f::Zero();  // a's frame, from a to b
  int face = -1, edge_a = -1, edge_b = -1;
  bool of_a = true;
};

// Maps b's frame to a's, with a unscaled.
struct Relative {
  Eigen::Matrix3f linear;  // rotation times scale
  Eigen::Matrix3f rotation;
  float scale;
  Vec3f offset;
  Vec3f operator()(const Vec3f& p) const { return linear * p + offset; }
};

float lowest(const std::vector<Vec3f>& vertices, const Vec3f& direction) {
  float least = 1e30f;
  for (const auto& v : vertices) least = std::min(least, direction.dot(v));
  return least;
}

// Tests the faces of `own` against all vertices of `other`. Stops beyond `enough`.
void try_faces(const Polytope& own, const Polytope& other, const Relative& other_in_own, float enough,
               bool of_a, Best& best, const Relative& b_in_a) {
  for (std::size_t f = 0; f < own.faces.size(); ++f) {
    const auto& face = own.faces[f];
    const Vec3f local = other_in_own.linear.transpose() * face.normal;
    float s = face.normal.dot(other_in_own.offset) - face.offset + lowest(other.vertices, local);
    if (!of_a) s *= b_in_a.scale;
    if (s <= best.separation) continue;
    best.separation = s;
    best.face = f;
    best.of_a = of_a;
    best.axis = of_a ? face.normal : Vec3f(-(b_in_a.rotation * face.normal));
    if (s > enough) return;
  }
}

// Whether the arcs between the faces' normals cross on the Gauss map. Only then do the two edges form a face
// of the Minkowski difference.
bool arcs_cross(const Vec3f& a, const Vec3f& b, const Vec3f& bxa, const Vec3f& c, const Vec3f& d,
                const Vec3f& dxc) {
  const float cba = c.dot(bxa), dba = d.dot(bxa), adc = a.dot(dxc), bdc = b.dot(dxc);
  return cba * dba < 0 && adc * bdc < 0 && cba * bdc > 0;
}

void try_edges(const Polytope& a, const Polytope& b, const Relative& b_in_a, float enough, Best& best) {
  for (std::size_t j = 0; j < b.edges.size(); ++j) {
    const auto& eb = b.edges[j];
    const Vec3f db = b_in_a.rotation * eb.direction;
    const Vec3f c = -(b_in_a.rotation * b.faces[eb.left].normal),
                d = -(b_in_a.rotation * b.faces[eb.right].normal);
    const Vec3f qb = b_in_a(b.vertices[eb.a]);
    for (std::size_t i = 0; i < a.edges.size(); ++i) {
      const auto& ea = a.edges[i];
      if (!arcs_cross(a.faces[ea.left].normal, a.faces[ea.right].normal, ea.direction, c, d, db)) continue;
      Vec3f axis = ea.direction.cross(db);
      const float length = axis.norm();
      if (length < 1e-3f) continue;  // parallel: a face normal covers this case
      axis /= length;
      if (axis.dot(a.vertices[ea.a]) < 0) axis = -axis;
      const float s = axis.dot(qb - a.vertices[ea.a]);
      if (s <= best.separation) continue;
      best = {s, axis, -1, static_cast<int>(i), static_cast<int>(j), true};
      if (s > enough) return;
    }
  }
}

int clip(const Vec3f* in, int n, const Vec3f& normal, float offset, Vec3f* out, int most) {
  int count = 0;
  for (int k = 0; k < n; ++k) {
    const Vec3f &p = in[k], &q = in[(k + 1) % n];
    const float dp = normal.dot(p) - offset, dq = normal.dot(q) - offset;
    if (dp <= 0 && count < most) out[count++] = p;
    if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) {
      if (count < most) out[count++] = p + (q - p) * (dp / (dp - dq));
    }
  }
  return count;
}

constexpr int kCorners = 96;

// `own` has the reference face; everything is in own's frame and unit. Points are on the incident face.
void clip_faces(const Polytope& own, int face, const Polytope& other, const Relative& other_in_own,
                float margin, float unit, const Eigen::Matrix3f& to_world, const Vec3f& shift,
                Manifold& out) {
  const auto& reference = own.faces[face];
  const Vec3f local = other_in_own.rotation.transpose() * reference.normal;
  std::size_t incident = 0;
  float least = 1e30f;
  for (std::size_t f = 0; f < other.faces.size(); ++f)
    if (const float v = other.faces[f].normal.dot(local); v < least) {
      least = v;
      incident = f;
    }
  Vec3f one[kCorners], two[kCorners];
  Vec3f *from = one, *to = two;
  int n = 0;
  for (std::int32_t v : other.faces[incident].loop)
    if (n < kCorners) from[n++] = other_in_own(other.vertices[v]);
  for (std::size_t k = 0; k < reference.loop.size() && n > 0; ++k) {
    const Vec3f& p = own.vertices[reference.loop[k]];
    const Vec3f& q = own.vertices[reference.loop[(k + 1) % reference.loop.size()]];
    const Vec3f side = (q - p).cross(reference.normal);
    n = clip(from, n, side, side.dot(p), to, kCorners);
    std::swap(from, to);
  }
  int stride = 1 + (n - 1) / Manifold::kMost;
  for (int k = 0; k < n; k += stride) {
    const float depth = margin - (reference.normal.dot(from[k]) - reference.offset) * unit;
    if (depth > 0 && out.count < Manifold::kMost)
      out.points[out.count++] = {to_world * (from[k] * unit) + shift, depth};
  }
}

// Midpoint of the edges' closest points, in a's frame.
Vec3f meet_edges(const Polytope& a, const Polytope& b, const Best& best, const Relative& b_in_a) {
  const auto &ea = a.edges[best.edge_a], &eb = b.edges[best.edge_b];
  const Vec3f p = a.vertices[ea.a], u = ea.direction, q = b_in_a(b.vertices[eb.a]),
              v = b_in_a.rotation * eb.direction;
  const Vec3f r = q - p;
  const float uv = u.dot(v), det = std::max(1 - uv * uv, 1e-6f);
  const float s = (r.dot(u) - uv * r.dot(v)) / det, t = (uv * r.dot(u) - r.dot(v)) / det;
  return 0.5f * (p + s * u + q + t * v);
}

struct Frames {
  Relative b_in_a, a_in_b;
  Frames(const PlacedPolytope& a, const PlacedPolytope& b, const Vec3f& offset) {
    b_in_a.rotation = a.rotation.transpose() * b.rotation;
    b_in_a.scale = b.scale / a.scale;
    b_in_a.linear = b_in_a.rotation * b_in_a.scale;
    b_in_a.offset = a.rotation.transpose() * offset / a.scale;
    a_in_b.rotation = b_in_a.rotation.transpose();
    a_in_b.scale = a.scale / b.scale;
    a_in_b.linear = a_in_b.rotation * a_in_b.scale;
    a_in_b.offset = -(b.rotation.transpose() * offset) / b.scale;
  }
};

// The axis of largest separation, in a's unit. The search ends beyond `enough`. A face is preferred to a pair
// of edges with only slightly larger separation, because a face has several contact points.
Best best_axis(const Polytope& a, const Polytope& b, const Frames& frames, float enough) {
  Best best;
  try_faces(a, b, frames.b_in_a, enough, true, best, frames.b_in_a);
  if (best.separation <= enough) try_faces(b, a, frames.a_in_b, enough, false, best, frames.b_in_a);
  if (best.separation > enough) return best;
  const Best faces = best;
  try_edges(a, b, frames.b_in_a, enough, best);
  if (best.face < 0 && best.separation <= enough &&
      best.separation < faces.separation + 0.01f * std::abs(faces.separation) + 1e-5f)
    return faces;
  return best;
}

float separation_along(const Vec3f& axis, const PlacedPolytope& a, const PlacedPolytope& b,
                       const Vec3f& offset) {
  return axis.dot(offset) + b.scale * lowest(b.polytope->vertices, b.rotation.transpose() * axis) +
         a.scale * lowest(a.polytope->vertices, -(a.rotation.transpose() * axis));
}

}  // namespace

void find_manifold(const PlacedPolytope& a, const PlacedPolytope& b, const Vec3f& offset, float margin,
                   Vec3f& hint, Manifold& out) {
  const Polytope &pa = *a.polytope, &pb = *b.polytope;
  out.count = 0;
  out.tests = static_cast<int>(pa.vertices.size() + pb.vertices.size()) / 16;
  if (!hint.isZero(0)) {
    const float s = separation_along(hint, a, b, offset);
    if (s > margin) {
      out.normal = hint;
      out.separation = s;
      return;
    }
  }
  out.tests += static_cast<int>(pa.faces.size() * pb.vertices.size() + pb.faces.size() * pa.vertices.size() +
                                pa.edges.size() * pb.edges.size()) /
               8;
  const Frames frames(a, b, offset);
  const Best best = best_axis(pa, pb, frames, margin / a.scale);
  out.separation = best.separation * a.scale;
  out.normal = a.rotation * best.axis;
  hint = out.normal;
  if (out.separation > margin) return;
  if (best.face < 0) {
    const Vec3f middle = meet_edges(pa, pb, best, frames.b_in_a);
    out.points[out.count++] = {a.rotation * middle * a.scale, margin - out.separation};
    return;
  }
  if (best.of_a)
    clip_faces(pa, best.face, pb, frames.b_in_a, margin, a.scale, a.rotation, Vec3f::Zero(), out);
  else
    clip_faces(pb, best.face, pa, frames.a_in_b, margin, b.scale, b.rotation, offset, out);
  // Rounding removed all corners of the clipped face: use the midpoint between the centers.
  if (out.count == 0) out.points[out.count++] = {0.5f * offset, std::max(margin - out.separation, 0.f)};
}

}  // namespace terrazzo::packing
