#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/bodies/carving/particle_colors.h"
#include "nodes/bodies/carving/particle_index.h"
#include "nodes/bodies/carving/ray_mesh.h"
#include "nodes/bodies/carving/solid.h"

namespace terrazzo::carving {
namespace {

class Heap : public Solid {
 public:
  Heap(const Particles& particles, const Shapes& shapes, const residual::ResidualField* residual,
       const residual::Skins* skins)
      : colors_(particles, residual, skins), longest_(static_cast<float>(particles.box.maxCoeff())) {
    const double longest = particles.box.maxCoeff();
    std::vector<RayScene::Triangles> meshes;
    for (const Shape& s : shapes.shapes) {
      bodies_.emplace_back(s);
      meshes.push_back(bodies_.back().triangles);
    }
    std::vector<RayScene::Instance> instances;
    double lowest = 0;
    for (std::size_t i = 0; i < particles.count(); ++i) {
      if (particles.is_void(i)) continue;
      const Mat3 rotation = particles.orientation[i].normalized().toRotationMatrix();
      const double scale = particles.scale[i] / longest;
      RayScene::Instance instance;
      instance.mesh = particles.shape[i];
      instance.linear = (rotation * scale).cast<float>();
      instance.offset = (particles.position[i] / longest).cast<float>();
      instances.push_back(instance);
      particle_.push_back(i);
      rotations_.push_back(rotation.cast<float>());
      mesh_of_.push_back(instance.mesh);
      for (const Vec3& v : shapes.shapes[instance.mesh].mesh.vertices)
        lowest = std::min(lowest, particles.position[i].z() / longest + scale * rotation.row(2).dot(v));
    }
    lowest_ = lowest;
    for (auto& i : instances) i.offset.z() -= lowest_;
    scene_ = std::make_unique<RayScene>(meshes, instances);
  }
  bool nearest(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, bool sharp) const override {
    RayHit hit;
    if (!scene_->nearest(origin, direction, hit)) return false;
    s.position = origin + hit.distance * direction;
    s.open = false;
    bodies_[mesh_of_[hit.instance]].normals_at(hit, s.face, s.normal);
    s.face = rotations_[hit.instance] * s.face;
    s.normal = rotations_[hit.instance] * s.normal;
    s.albedo = colors_.at((s.position + Vec3f(0, 0, lowest_)) * longest_, particle_[hit.instance], sharp)
                   .cwiseMin(1.0f);
    return true;
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    return scene_->any(origin, direction);
  }
  Eigen::AlignedBox3f bounds() const override { return scene_->bounds(); }

 private:
  ParticleColors colors_;
  float longest_, lowest_ = 0;
  std::vector<RayMesh> bodies_;
  std::vector<Eigen::Matrix3f> rotations_;
  std::vector<std::uint32_t> mesh_of_;
  std::vector<int> particle_;  // of each instance
  std::unique_ptr<RayScene> scene_;
};

}  // namespace

std::unique_ptr<Solid> particle_solid(const Particles& particles, const Shapes& shapes,
                                      const residual::ResidualField* residual, const residual::Skins* skins) {
  check_shown(particles, shapes);
  if (particles.void_count() == particles.count())
    throw Error("no-particles", "all particles are voids, so nothing is left without the binder",
                "use another mode, such as block or object");
  return std::make_unique<Heap>(particles, shapes, residual, skins);
}

}  // namespace terrazzo::carving
