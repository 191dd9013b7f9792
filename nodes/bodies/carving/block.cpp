#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/bodies/carving/body.h"
#include "nodes/bodies/carving/ray_scene.h"

namespace terrazzo::carving {
namespace {

class Block : public CarvedBody {
 public:
  Block(const Vec3f& size, double cut, double bevel)
      : bevel_(static_cast<float>(bevel)), has_cut_(cut > 0), size_(size) {
    const float c = cut;
    low_ = Vec3f(size_.x() * (1 - c), 0, size_.z() * (1 - c));
    high_ = Vec3f(size_.x(), size_.y() * c, size_.z());
    scene_ = std::make_unique<RayScene>(std::vector<RayScene::Triangles>{faces()},
                                        std::vector<RayScene::Instance>{{}});
  }

  bool meet(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, float& at) const override {
    RayHit hit;
    if (!scene_->nearest(origin, direction, hit)) return false;
    at = hit.distance;
    const Face& face = faces_[owner_[hit.triangle]];
    s.position = origin + hit.distance * direction;
    s.position[face.axis] = face.at;
    s.face = Vec3f::Zero();
    s.face[face.axis] = face.sign;
    s.normal = rounded(s.position, face);
    s.open = owner_[hit.triangle] < 6;
    return true;
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    return scene_->any(origin, direction);
  }
  Eigen::AlignedBox3f bounds() const override { return {Vec3f(Vec3f::Zero()), size_}; }

 private:
  struct Face {
    int axis;
    float sign, at;
  };

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

  // Adds a rectangle of a face, given by two opposite corners.
  void rectangle(RayScene::Triangles& t, int face, const Vec3f& a, const Vec3f& b) {
    const int k = faces_[face].axis, i = (k + 1) % 3, j = (k + 2) % 3;
    if (b[i] - a[i] <= 0 || b[j] - a[j] <= 0) return;
    const std::uint32_t first = t.positions.size();
    for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      Vec3f p;
      p[k] = faces_[face].at;
      p[i] = u ? b[i] : a[i];
      p[j] = v ? b[j] : a[j];
      t.positions.push_back(p);
    }
    for (const std::uint32_t q : {0u, 1u, 2u, 0u, 2u, 3u}) t.indices.push_back(first + q);
    owner_.insert(owner_.end(), 2, face);
  }

  RayScene::Triangles faces() {
    RayScene::Triangles t;
    for (int k = 0; k < 3; ++k) {
      faces_.push_back({k, -1, 0});
      faces_.push_back({k, 1, size_[k]});
    }
    const Vec3f zero = Vec3f::Zero();
    for (int f = 0; f < 6; ++f) {
      const int k = f / 2, i = (k + 1) % 3, j = (k + 2) % 3;
      const bool opened = has_cut_ && (f == 1 || f == 2 || f == 5);  // +x, −y, +z
      if (!opened) {
        rectangle(t, f, zero, size_);
        continue;
      }
      // The face without the rectangle removed by the cut.
      Vec3f a = zero, b = size_;
      const bool from_low_i = low_[i] == 0;
      (from_low_i ? a : b)[i] = from_low_i ? high_[i] : low_[i];
      rectangle(t, f, a, b);
      Vec3f c = zero, d = size_;
      c[i] = low_[i];
      d[i] = high_[i];
      const bool from_low_j = low_[j] == 0;
      (from_low_j ? c : d)[j] = from_low_j ? high_[j] : low_[j];
      rectangle(t, f, c, d);
    }
    if (has_cut_) {
      faces_.push_back({0, 1, low_.x()}), faces_.push_back({1, -1, high_.y()}),
          faces_.push_back({2, 1, low_.z()});
      for (int f = 6; f < 9; ++f) rectangle(t, f, low_, high_);
    }
    return t;
  }

  float bevel_;
  bool has_cut_;
  Vec3f size_, low_, high_;  // of the block; corners of the removed part
  std::vector<Face> faces_;
  std::vector<int> owner_;  // face of each triangle
  std::unique_ptr<RayScene> scene_;
};

}  // namespace

std::unique_ptr<CarvedBody> block_body(const Vec3f& size, double cut, double bevel) {
  return std::make_unique<Block>(size, cut, bevel);
}

}  // namespace terrazzo::carving
