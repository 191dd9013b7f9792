// A mesh along a direction: its vertices sorted by height, and the contribution of each triangle to the area
// of a section.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/data/shapes.h"

namespace terrazzo {

// Vertices in coordinates whose z axis is a given direction, sorted by z; ties are sorted by vertex index.
class HeightOrder {
 public:
  explicit HeightOrder(const Mesh& mesh);
  void set(const Vec3& direction);

  const Vec3& point(std::int32_t vertex) const { return point_[vertex]; }
  std::int32_t rank(std::int32_t vertex) const { return rank_[vertex]; }
  std::int32_t vertex(std::int32_t rank) const { return order_[rank]; }
  double height(std::int32_t rank) const { return height_[rank]; }
  std::int32_t count() const { return static_cast<std::int32_t>(point_.size()); }

 private:
  const Mesh& mesh_;
  Vec3 middle_;  // origin of the coordinates, near the body, so that areas of a distant body lose no digits
  std::vector<Vec3> point_;
  std::vector<std::int32_t> order_, rank_, bucket_;
  std::vector<double> height_;
};

struct Quadratic {
  double c0 = 0, c1 = 0, c2 = 0;
  double operator()(double z) const { return c0 + z * (c1 + z * c2); }
  Quadratic& operator+=(const Quadratic& q) {
    c0 += q.c0;
    c1 += q.c1;
    c2 += q.c2;
    return *this;
  }
  Quadratic& operator-=(const Quadratic& q) {
    c0 -= q.c0;
    c1 -= q.c1;
    c2 -= q.c2;
    return *this;
  }
};

// The cut of a triangle between two of its edges at depth z. Half the cross product of its ends, summed over
// a closed loop, is the loop's area.
class Chord {
 public:
  // Edges p → p_end and q → q_end point upwards; sign is −1 if the cut runs from q to p.
  Chord(const Vec3& p, const Vec3& p_end, const Vec3& q, const Vec3& q_end, double sign)
      : p_(p), q_(q), half_(sign / 2), valid_(p_end.z() > p.z() && q_end.z() > q.z()) {
    if (!valid_) return;
    p1_ = (p_end - p).head<2>() / (p_end.z() - p.z());
    q1_ = (q_end - q).head<2>() / (q_end.z() - q.z());
  }
  bool valid() const { return valid_; }
  // The coefficients grow with the inverse square of the edges' heights, so sums of them lose digits if the
  // heights are small.
  Quadratic area() const {
    const Vec2 p0 = p_.head<2>() - p1_ * p_.z(), q0 = q_.head<2>() - q1_ * q_.z();
    return {half_ * cross(p0, q0), half_ * (cross(p0, q1_) + cross(p1_, q0)), half_ * cross(p1_, q1_)};
  }
  double area(double z) const { return half_ * cross(p_at(z), q_at(z)); }
  Vec2 p_at(double z) const { return p_.head<2>() + p1_ * (z - p_.z()); }
  Vec2 q_at(double z) const { return q_.head<2>() + q1_ * (z - q_.z()); }

 private:
  Vec3 p_, q_;
  Vec2 p1_, q1_;
  double half_;
  bool valid_;
};

// A triangle's vertices sorted by rank; `sign` is +1 if this order has the orientation of the triangle.
struct RankedTriangle {
  std::int32_t low, middle, high;
  double sign;
  RankedTriangle(const HeightOrder& order, const Triangle& t);
  // The cut below and above the middle vertex.
  Chord lower(const HeightOrder& o) const {
    return {o.point(low), o.point(high), o.point(low), o.point(middle), sign};
  }
  Chord upper(const HeightOrder& o) const {
    return {o.point(low), o.point(high), o.point(middle), o.point(high), sign};
  }
};

inline RankedTriangle::RankedTriangle(const HeightOrder& order, const Triangle& t)
    : low(t[0]), middle(t[1]), high(t[2]), sign(1) {
  if (order.rank(low) > order.rank(middle)) {
    std::swap(low, middle);
    sign = -sign;
  }
  if (order.rank(middle) > order.rank(high)) {
    std::swap(middle, high);
    sign = -sign;
  }
  if (order.rank(low) > order.rank(middle)) {
    std::swap(low, middle);
    sign = -sign;
  }
}

}  // namespace terrazzo
