#include <cmath>

#include "nodes/bodies/carving/body.h"

namespace terrazzo::carving {
namespace {

constexpr float kFar = 1e30f;  // beyond every surface

// A box, without the corner {x > low.x, y < high.y, z > low.z} if it has a cut.
class Block : public CarvedBody {
 public:
  Block(const Vec3f& size, double cut, double bevel)
      : bevel_(static_cast<float>(bevel)), has_cut_(cut > 0), size_(size) {
    const float c = cut;
    low_ = Vec3f(size_.x() * (1 - c), 0, size_.z() * (1 - c));
    high_ = Vec3f(size_.x(), size_.y() * c, size_.z());
  }

  bool meet(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, float& at) const override {
    Face face;
    if (!first(origin, direction, at, face)) return false;
    s.position = origin + at * direction;
    s.position[face.axis] = face.at;
    s.face = Vec3f::Zero();
    s.face[face.axis] = face.sign;
    s.normal = rounded(s.position, face);
    s.open = !face.inner;
    return true;
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    float at;
    Face face;
    return first(origin, direction, at, face);
  }
  Eigen::AlignedBox3f bounds() const override { return {Vec3f(Vec3f::Zero()), size_}; }

 private:
  struct Face {
    int axis = 0;
    float sign = 1, at = 0;
    bool inner = false;  // of the cut
  };
  // The part of a ray within a convex region, and the faces through which it enters and leaves.
  struct Part {
    float from = -kFar, to = kFar;
    Face in, out;
  };

  // Keeps the part on the inner side of a face.
  static void keep(Part& part, const Vec3f& origin, const Vec3f& direction, const Face& face) {
    const float d = face.sign * direction[face.axis], beyond = face.sign * (origin[face.axis] - face.at);
    if (d == 0) {
      if (beyond > 0 || (face.inner && beyond == 0)) part.to = -kFar;  // the cut is open
      return;
    }
    const float at = -beyond / d;
    if (d < 0 && at > part.from) {
      part.from = at;
      part.in = face;
    } else if (d > 0 && at < part.to) {
      part.to = at;
      part.out = face;
    }
  }

  // The first surface along the ray, from outside or inside.
  bool first(const Vec3f& origin, const Vec3f& direction, float& at, Face& face) const {
    Part box;
    for (int k = 0; k < 3; ++k) {
      keep(box, origin, direction, {k, -1, 0});
      keep(box, origin, direction, {k, 1, size_[k]});
    }
    if (!(box.from < box.to && box.to > 0 && box.to < kFar)) return false;
    const auto hit = [&](float distance, const Face& where) {
      if (distance <= 0) return false;
      at = distance;
      face = where;
      return true;
    };
    Part cut;
    if (has_cut_) {
      keep(cut, origin, direction, {0, -1, low_.x(), true});
      keep(cut, origin, direction, {1, 1, high_.y(), true});
      keep(cut, origin, direction, {2, -1, low_.z(), true});
    }
    if (!has_cut_ || cut.from >= cut.to || cut.to <= box.from || cut.from >= box.to)
      return hit(box.from, box.in) || hit(box.to, box.out);
    // Where the ray enters the cut, it leaves the solid, and the other way round.
    const auto turned = [](Face f) {
      f.sign = -f.sign;
      return f;
    };
    if (cut.from > box.from && (hit(box.from, box.in) || hit(cut.from, turned(cut.in)))) return true;
    return cut.to < box.to && (hit(cut.to, turned(cut.out)) || hit(box.to, box.out));
  }

  bool inside(const Vec3f& p) const {
    for (int k = 0; k < 3; ++k)
      if (p[k] < 0 || p[k] > size_[k]) return false;
    return !(has_cut_ && p.x() > low_.x() && p.y() < high_.y() && p.z() > low_.z());
  }

  // The normal of an edge rounded to a quarter circle of radius bevel_.
  Vec3f rounded(const Vec3f& p, const Face& face) const {
    Vec3f n = Vec3f::Zero();
    n[face.axis] = face.sign;
    for (int step = 1; step <= 2; ++step) {
      const int k = (face.axis + step) % 3;
      for (const float edge : {0.0f, size_[k], k == 1 ? high_.y() : low_[k]}) {
        const float d = std::abs(edge - p[k]);
        if (d >= bevel_) continue;
        const float out = p[k] < edge ? 1.0f : -1.0f;
        Vec3f beyond = p;
        beyond[face.axis] -= face.sign * 1e-4f;
        beyond[k] = edge + out * 1e-4f;
        if (!inside(beyond)) n[k] += out * std::tan(0.785398f * (1 - d / bevel_));
      }
    }
    return n.normalized();
  }

  float bevel_;
  bool has_cut_;
  Vec3f size_, low_, high_;  // of the block; corners of the removed part
};

}  // namespace

std::unique_ptr<CarvedBody> block_body(const Vec3f& size, double cut, double bevel) {
  return std::make_unique<Block>(size, cut, bevel);
}

}  // namespace terrazzo::carving
