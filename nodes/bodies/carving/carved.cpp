#include <limits>

#include "nodes/bodies/carving/body.h"
#include "nodes/bodies/carving/hollows.h"
#include "nodes/bodies/carving/paint.h"

namespace terrazzo::carving {
namespace {

class Carved : public Solid {
 public:
  Carved(const Paint& paint, std::unique_ptr<CarvedBody> body) : paint_(paint), body_(std::move(body)) {}
  bool nearest(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, bool sharp) const override {
    float at;
    if (!body_->meet(origin, direction, s, at)) return false;
    s.albedo = paint_.at(s.position, s.face, sharp);
    return true;
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    return body_->any(origin, direction);
  }
  Eigen::AlignedBox3f bounds() const override { return body_->bounds(); }

 private:
  const Paint& paint_;
  std::unique_ptr<CarvedBody> body_;
};

// A body with holes. Rays start in air, outside or in a hole, and continue until they enter material.
class Hollowed : public Solid {
 public:
  Hollowed(const Paint& paint, std::unique_ptr<CarvedBody> body, std::unique_ptr<Hollows> hollows)
      : paint_(paint), body_(std::move(body)), hollows_(std::move(hollows)) {}
  bool nearest(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, bool sharp) const override {
    if (!walk(origin, direction, s)) return false;
    s.albedo = paint_.at(s.position, s.face, sharp);
    return true;
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    SurfacePoint s;
    return walk(origin, direction, s);
  }
  Eigen::AlignedBox3f bounds() const override { return body_->bounds(); }

 private:
  // Whether a hole is open at a point where a ray enters the body, and the wall that the ray meets next.
  bool opens(const Vec3f& p, const Vec3f& d, HollowHit& wall) const {
    if (!hollows_->known()) return hollows_->nearest(p, d, wall) && wall.leaves;
    // A wall that lies in the body's face is behind the ray.
    const Vec3f inside = p + kBeyond * d;
    if (hollows_->nearest(inside, d, wall))
      wall.at += kBeyond;
    else
      wall.at = std::numeric_limits<float>::max();
    SurfacePoint end;
    float to;
    if (!body_->meet(inside, d, end, to)) return false;
    // A hole may also end where the body does. Halfway to there, walls are far.
    return wall.at < to ? wall.leaves : hollows_->holds(p + to / 2 * d);
  }
  bool walk(const Vec3f& origin, const Vec3f& d, SurfacePoint& s) const {
    float from = 0;
    for (int step = 0; step < 256; ++step) {
      const Vec3f p = origin + from * d;
      SurfacePoint outer;
      float to;
      if (!body_->meet(p, d, outer, to)) return false;
      const bool leaves = outer.face.dot(d) > 0;
      // From outside, material begins at the body's surface unless a hole is open there; from inside a hole,
      // it begins at the hole's wall unless the body ends first.
      HollowHit wall;
      if (!leaves) {
        if (!opens(p + to * d, d, wall)) {
          s = outer;
          return true;
        }
        from += to;
        to = 0;
      } else if (!hollows_->nearest(p, d, wall) || !wall.leaves) {
        from += to + kBeyond;  // a ray that grazed an edge continues in air
        continue;
      }
      // Inside a hole within the body: which of them ends first?
      if (!leaves) {
        from += kBeyond;
        if (!body_->meet(origin + from * d, d, outer, to)) return false;
      }
      if (wall.at < to) {
        s.position = origin + (from + wall.at) * d;
        s.face = -wall.face;
        s.normal = -wall.normal;
        s.open = false;
        return true;
      }
      from += to + kBeyond;
    }
    return false;
  }

  const Paint& paint_;
  std::unique_ptr<CarvedBody> body_;
  std::unique_ptr<Hollows> hollows_;
};

std::unique_ptr<Solid> carved(const Paint& paint, std::unique_ptr<CarvedBody> body, const Voids& voids) {
  if (!voids.particles || voids.particles->void_count() == 0)
    return std::make_unique<Carved>(paint, std::move(body));
  auto hollows = std::make_unique<Hollows>(voids, body->bounds());
  return std::make_unique<Hollowed>(paint, std::move(body), std::move(hollows));
}

}  // namespace

std::unique_ptr<Solid> block_solid(const Paint& paint, double cut, double bevel, const Voids& voids) {
  return carved(paint, block_body(paint.period(), cut, bevel), voids);
}

std::unique_ptr<Solid> object_solid(const Paint& paint, const Shape& object, const Voids& voids) {
  return carved(paint, object_body(object), voids);
}

}  // namespace terrazzo::carving
