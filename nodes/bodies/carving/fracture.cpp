#include <algorithm>
#include <cmath>

#include "nodes/bodies/carving/broken_block.h"
#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/particle_colors.h"
#include "nodes/bodies/carving/ray_mesh.h"
#include "nodes/bodies/carving/solid.h"

namespace terrazzo::carving {
namespace {

class Fracture : public Solid {
 public:
  Fracture(const Paint& paint, const Particles& particles, const Shapes& shapes, double level,
           double roughness, std::uint64_t seed, const residual::ResidualField* residual)
      : paint_(paint), block_(particles, shapes, level, roughness, seed), colors_(particles, residual) {
    std::vector<RayScene::Triangles> meshes;
    for (const Shape& s : shapes.shapes) {
      bodies_.emplace_back(s);
      meshes.push_back(bodies_.back().triangles);
    }
    particles_ = std::make_unique<RayScene>(meshes, block_.instances());
    binder_ = std::make_unique<RayMesh>(block_.under_the_face());
    binder_scene_ = std::make_unique<RayScene>(std::vector<RayScene::Triangles>{binder_->triangles},
                                               std::vector<RayScene::Instance>{{}});
    const Vec3f size = block_.size();
    bounds_ = Eigen::AlignedBox3f(Vec3f(Vec3f::Zero()), Vec3f(size.x(), size.y(), block_.top() + 1e-3f));
  }

  bool nearest(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, bool sharp) const override {
    return walk(origin, direction, &s, sharp);
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    return walk(origin, direction, nullptr, false);
  }
  Eigen::AlignedBox3f bounds() const override { return bounds_; }

 private:
  struct Event {
    bool met = false;
    float at = 0;  // distance along the ray
    RayHit hit;
    Vec3f face, normal;  // outwards
    bool leaves = false;
  };

  Event next_particle(const Vec3f& origin, const Vec3f& d, float from) const {
    Event e;
    e.met = particles_->nearest(origin + from * d, d, e.hit);
    if (!e.met) return e;
    e.at = from + e.hit.distance;
    const BrokenBlock::Image& image = block_.images()[e.hit.instance];
    bodies_[image.mesh].normals_at(e.hit, e.face, e.normal);
    e.face = image.turn * e.face;
    e.normal = image.turn * e.normal;
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
      if (std::min(a, b) > from) {
        from = std::min(a, b);
        axis = k;
      }
      to = std::min(to, std::max(a, b));
    }
    if (!(from < to)) return false;
    Event p = next_particle(origin, d, from), b = next_binder(origin, d, from);
    int within = p.met && p.leaves ? static_cast<int>(p.hit.instance) : -1;
    // The face is an open surface. Decide whether the start is below it by the next hit from below, or else
    // by the height.
    const Vec3f start = origin + from * d;
    bool under = b.met ? b.leaves : start.z() < block_.height(start.x(), start.y());
    bool solid = within >= 0 ? block_.images()[within].stays : under;
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
      const bool now = within >= 0 ? block_.images()[within].stays : under;
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
    s->position = at;
    s->face = face;
    s->normal = normal;
    s->open = false;
    // A particle has its own color all over; elsewhere the paint provides the color just below the surface.
    s->albedo = within >= 0 ? colors_.at(at * block_.longest(), block_.images()[within].particle, sharp)
                            : paint_.at(at, face, sharp);
    return true;
  }

  const Paint& paint_;
  BrokenBlock block_;
  ParticleColors colors_;
  std::vector<RayMesh> bodies_;
  std::unique_ptr<RayMesh> binder_;
  std::unique_ptr<RayScene> particles_, binder_scene_;
  Eigen::AlignedBox3f bounds_;
};

}  // namespace

std::unique_ptr<Solid> fracture_solid(const Paint& paint, const Particles& particles, const Shapes& shapes,
                                      double level, double roughness, std::uint64_t seed,
                                      const residual::ResidualField* residual) {
  return std::make_unique<Fracture>(paint, particles, shapes, level, roughness, seed, residual);
}

}  // namespace terrazzo::carving
