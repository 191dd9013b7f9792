#include <algorithm>
#include <cmath>

#include "nodes/common/texture/noise.h"
#include "nodes/render_solid/paint.h"
#include "nodes/render_solid/particle_colors.h"
#include "nodes/render_solid/particle_index.h"
#include "nodes/render_solid/ray_mesh.h"
#include "nodes/render_solid/solid.h"

namespace terrazzo::render_solid {
namespace {

class Fracture : public Solid {
 public:
  Fracture(const Paint& paint, const Particles& particles, const Shapes& shapes, double level,
           double roughness, std::uint64_t seed, const residual::ResidualField* residual)
      : paint_(paint), level_(level), roughness_(roughness), seed_(seed), colors_(particles, residual) {
    const double longest = particles.box.maxCoeff();
    longest_ = static_cast<float>(longest);
    size_ = (particles.box / longest).cast<float>();
    std::vector<RayScene::Triangles> meshes;
    std::vector<double> radius;
    for (const Shape& s : shapes.shapes) {
      bodies_.emplace_back(s), meshes.push_back(bodies_.back().triangles);
      double far = 0;
      for (const Vec3& v : s.mesh.vertices) far = std::max(far, v.norm());
      radius.push_back(far);
    }
    std::vector<RayScene::Instance> instances;
    float top = static_cast<float>(level + 2 * roughness) * size_.z();
    const float highest = static_cast<float>(level + 1.35 * roughness) * size_.z();  // of the face
    for (std::size_t i = 0; i < particles.count(); ++i) {
      const auto mesh = static_cast<std::uint32_t>(particles.shape[i]);
      const Mat3 turn = particles.orientation[i].normalized().toRotationMatrix();
      const auto r = static_cast<float>(radius[mesh] * particles.scale[i] / longest);
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
          for (int z = -1; z <= 1; ++z) {
            const Vec3f at =
                (particles.position[i] / longest).cast<float>() + Vec3f(x, y, z).cwiseProduct(size_);
            if ((at.array() + r < 0).any() || (at.array() - r > size_.array()).any()) continue;
            const bool stays = !particles.is_void(i) && at.z() < height(at.x(), at.y());
            if (!stays && at.z() - r > highest) continue;  // removed, and too high to leave a socket
            RayScene::Instance instance;
            instance.mesh = mesh;
            instance.linear = (turn * (particles.scale[i] / longest)).cast<float>();
            instance.offset = at;
            instances.push_back(instance);
            images_.push_back({i, mesh, turn.cast<float>(), stays});
            if (stays) top = std::max(top, at.z() + r);
          }
    }
    particles_ = std::make_unique<RayScene>(meshes, instances);
    binder_ = std::make_unique<RayMesh>(under_the_face());
    binder_scene_ = std::make_unique<RayScene>(std::vector<RayScene::Triangles>{binder_->triangles},
                                               std::vector<RayScene::Instance>{{}});
    bounds_ = Eigen::AlignedBox3f(Vec3f(Vec3f::Zero()), Vec3f(size_.x(), size_.y(), top + 1e-3f));
  }

  bool nearest(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, bool sharp) const override {
    return walk(origin, direction, &s, sharp);
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    return walk(origin, direction, nullptr, false);
  }
  Eigen::AlignedBox3f bounds() const override { return bounds_; }

 private:
  struct Image {
    std::size_t particle;
    std::uint32_t mesh;
    Eigen::Matrix3f turn;
    bool stays;
  };
  struct Event {
    bool met = false;
    float at = 0;  // distance along the ray
    RayHit hit;
    Vec3f face, normal;  // outwards
    bool leaves = false;
  };

  float height(float x, float y) const {
    const Vec3 p(4.0 * x + 0.3, 4.0 * y + 0.7, 0.5);
    return static_cast<float>(level_ + roughness_ * (noise(seed_, p) + 0.35 * noise(seed_ + 1, 5 * p))) *
           size_.z();
  }

  // Everything under the rough face, wider than the block; walk() cuts it at the block's sides.
  RayMesh under_the_face() const {
    constexpr int n = 480;  // fine enough that its facets do not shade each other in grazing light
    Shape s;
    s.smooth = true;
    const auto place = [&](int i, float edge) { return double(edge) * (1.1 * i / n - 0.05); };
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double x = place(i, size_.x()), y = place(j, size_.y());
        s.mesh.vertices.push_back(Vec3(x, y, height(float(x), float(y))));
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i;
        s.mesh.triangles.push_back({a, a + 1, a + n + 2});
        s.mesh.triangles.push_back({a, a + n + 2, a + n + 1});
      }
    return RayMesh(s);
  }

  Event next_particle(const Vec3f& origin, const Vec3f& d, float from) const {
    Event e;
    e.met = particles_->nearest(origin + from * d, d, e.hit);
    if (!e.met) return e;
    e.at = from + e.hit.distance;
    const Image& image = images_[e.hit.instance];
    bodies_[image.mesh].normals_at(e.hit, e.face, e.normal);
    e.face = image.turn * e.face, e.normal = image.turn * e.normal;
    e.leaves = e.face.dot(d) > 0;
    return e;
  }
  Event next_binder(const Vec3f& origin, const Vec3f& d, float from) const {
    Event e;
    e.met = binder_scene_->nearest(origin + from * d, d, e.hit);
    if (!e.met) return e;
    e.at = from + e.hit.distance;
    binder_->normals_at(e.hit, e.face, e.normal);
    e.leaves = e.face.dot(d) > 0;
    return e;
  }

  // Along the ray, the remaining block begins where the ray enters a particle that stays, leaves a removed
  // particle into binder, enters binder, or enters either through a side. Particles do not overlap, so a
  // point is inside at most one.
  bool walk(const Vec3f& origin, const Vec3f& d, SurfacePoint* s, bool sharp) const {
    float from = 0, to = 1e30f;
    int axis = -1;
    for (int k = 0; k < 3; ++k) {
      const float inverse = 1 / (std::abs(d[k]) < 1e-12f ? 1e-12f : d[k]);
      const float a = (bounds_.min()[k] - origin[k]) * inverse, b = (bounds_.max()[k] - origin[k]) * inverse;
      if (std::min(a, b) > from) from = std::min(a, b), axis = k;
      to = std::min(to, std::max(a, b));
    }
    if (!(from < to)) return false;
    Event p = next_particle(origin, d, from), b = next_binder(origin, d, from);
    int within = p.met && p.leaves ? static_cast<int>(p.hit.instance) : -1;
    // The face is an open surface. Decide whether the start is below it by the next hit from below, or else
    // by the height.
    const Vec3f start = origin + from * d;
    bool under = b.met ? b.leaves : start.z() < height(start.x(), start.y());
    bool solid = within >= 0 ? images_[within].stays : under;
    if (solid && axis >= 0 && !(axis == 2 && d.z() < 0)) {
      Vec3f side = Vec3f::Zero();
      side[axis] = d[axis] > 0 ? -1.0f : 1.0f;
      return found(s, start, side, side, within, sharp);
    }
    for (int step = 0; step < 256; ++step) {
      const bool particle = p.met && (!b.met || p.at <= b.at);
      const Event e = particle ? p : b;
      if (!e.met || e.at > to) return false;
      if (particle)
        within = e.leaves ? -1 : static_cast<int>(e.hit.instance);
      else
        under = !e.leaves;
      const bool now = within >= 0 ? images_[within].stays : under;
      if (now && !solid) {
        const float sign = e.leaves ? -1.0f : 1.0f;
        return found(s, origin + e.at * d, sign * e.face, sign * e.normal, within, sharp);
      }
      solid = now;
      if (particle)
        p = next_particle(origin, d, e.at + kBeyond);
      else
        b = next_binder(origin, d, e.at + kBeyond);
    }
    return false;
  }

  bool found(SurfacePoint* s, const Vec3f& at, const Vec3f& face, const Vec3f& normal, int within,
             bool sharp) const {
    if (!s) return true;
    s->position = at, s->face = face, s->normal = normal, s->open = false;
    // A particle has its own color all over; elsewhere the paint provides the color just below the surface.
    s->albedo = within >= 0 ? colors_.at(at * longest_, static_cast<int>(images_[within].particle), sharp)
                            : paint_.at(at, face, sharp);
    return true;
  }

  const Paint& paint_;
  double level_, roughness_;
  std::uint64_t seed_;
  ParticleColors colors_;
  float longest_ = 1;  // mm per world unit
  Vec3f size_;
  std::vector<RayMesh> bodies_;
  std::vector<Image> images_;
  std::unique_ptr<RayMesh> binder_;
  std::unique_ptr<RayScene> particles_, binder_scene_;
  Eigen::AlignedBox3f bounds_;
};

}  // namespace

std::unique_ptr<Solid> fracture_solid(const Paint& paint, const Particles& particles, const Shapes& shapes,
                                      double level, double roughness, std::uint64_t seed,
                                      const residual::ResidualField* residual) {
  check_shown(particles, shapes);
  return std::make_unique<Fracture>(paint, particles, shapes, level, roughness, seed, residual);
}

}  // namespace terrazzo::render_solid
