#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/render_mesh.h"
#include "nodes/render_solid/color_field.h"
#include "nodes/render_solid/ray_scene.h"
#include "nodes/render_solid/solid.h"

namespace terrazzo {
namespace {

// A mesh with its normals in single precision.
struct Body {
  RayScene::Triangles triangles;
  std::vector<Vec3f> normals;

  explicit Body(const Shape& shape, const Vec3& offset = Vec3::Zero(), double scale = 1) {
    const RenderMesh m = render_mesh(shape);
    for (const Vec3& p : m.positions) triangles.positions.push_back(((p + offset) * scale).cast<float>());
    for (const Vec3& n : m.normals) normals.push_back(n.cast<float>());
    triangles.indices = m.indices;
  }
  void normals_at(const RayHit& hit, Vec3f& face, Vec3f& normal) const {
    const std::uint32_t* i = &triangles.indices[3 * static_cast<std::size_t>(hit.triangle)];
    const auto& p = triangles.positions;
    face = (p[i[1]] - p[i[0]]).cross(p[i[2]] - p[i[0]]).normalized();
    normal =
        (normals[i[0]] * (1 - hit.u - hit.v) + normals[i[1]] * hit.u + normals[i[2]] * hit.v).normalized();
  }
};

class Carved : public Solid {
 public:
  Carved(const ColorField& field, const Shape& shape, double repeat) : field_(field), body_(placed(shape)) {
    voxels_per_unit_ = static_cast<float>(field.resolution().maxCoeff() * repeat);
    scene_ = std::make_unique<RayScene>(std::vector<RayScene::Triangles>{body_.triangles},
                                        std::vector<RayScene::Instance>{{}});
  }
  bool nearest(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, bool sharp) const override {
    RayHit hit;
    if (!scene_->nearest(origin, direction, hit)) return false;
    s.position = origin + hit.distance * direction;
    body_.normals_at(hit, s.face, s.normal);
    const Vec3f voxel = s.position * voxels_per_unit_;
    s.albedo = sharp ? field_.sharp(voxel) : field_.at(voxel);
    s.open = false;
    return true;
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    return scene_->any(origin, direction);
  }
  Eigen::AlignedBox3f bounds() const override { return scene_->bounds(); }

 private:
  static Body placed(const Shape& shape) {
    Eigen::AlignedBox3d box;
    for (const Vec3& v : shape.mesh.vertices) box.extend(v);
    const double longest = box.isEmpty() ? 0 : box.sizes().maxCoeff();
    if (!(longest > 0) || !std::isfinite(longest))
      throw Error("bad-mesh", "the object '" + shape.name + "' has no extent");
    return Body(shape, -box.min(), 1 / longest);
  }
  const ColorField& field_;
  Body body_;
  float voxels_per_unit_;
  std::unique_ptr<RayScene> scene_;
};

class Heap : public Solid {
 public:
  Heap(const Particles& particles, const Shapes& shapes) : colors_(particles.color) {
    const double longest = particles.box.maxCoeff();
    if (!(longest > 0) || !std::isfinite(longest)) throw Error("bad-box", "the particles' box has no extent");
    std::vector<RayScene::Triangles> meshes;
    for (const Shape& s : shapes.shapes) bodies_.emplace_back(s), meshes.push_back(bodies_.back().triangles);
    std::vector<RayScene::Instance> instances(particles.count());
    double lowest = 0;
    for (std::size_t i = 0; i < particles.count(); ++i) {
      const Mat3 rotation = particles.orientation[i].normalized().toRotationMatrix();
      const double scale = particles.scale[i] / longest;
      instances[i].mesh = static_cast<std::uint32_t>(particles.shape[i]);
      instances[i].linear = (rotation * scale).cast<float>();
      instances[i].offset = (particles.position[i] / longest).cast<float>();
      rotations_.push_back(rotation.cast<float>());
      mesh_of_.push_back(instances[i].mesh);
      for (const Vec3& v : shapes.shapes[instances[i].mesh].mesh.vertices)
        lowest = std::min(lowest, particles.position[i].z() / longest + scale * rotation.row(2).dot(v));
    }
    for (auto& i : instances) i.offset.z() -= static_cast<float>(lowest);
    scene_ = std::make_unique<RayScene>(meshes, instances);
  }
  bool nearest(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, bool) const override {
    RayHit hit;
    if (!scene_->nearest(origin, direction, hit)) return false;
    s.position = origin + hit.distance * direction;
    s.open = false;
    bodies_[mesh_of_[hit.instance]].normals_at(hit, s.face, s.normal);
    s.face = rotations_[hit.instance] * s.face;
    s.normal = rotations_[hit.instance] * s.normal;
    s.albedo = colors_[hit.instance].cwiseMax(0.0f).cwiseMin(1.0f);
    return true;
  }
  bool any(const Vec3f& origin, const Vec3f& direction) const override {
    return scene_->any(origin, direction);
  }
  Eigen::AlignedBox3f bounds() const override { return scene_->bounds(); }

 private:
  std::vector<Vec3f> colors_;
  std::vector<Body> bodies_;
  std::vector<Eigen::Matrix3f> rotations_;
  std::vector<std::uint32_t> mesh_of_;
  std::unique_ptr<RayScene> scene_;
};

}  // namespace

std::unique_ptr<Solid> object_solid(const ColorField& field, const Shape& object, double repeat) {
  return std::make_unique<Carved>(field, object, repeat);
}

std::unique_ptr<Solid> particle_solid(const Particles& particles, const Shapes& shapes) {
  if (particles.count() == 0) throw Error("no-particles", "there are no particles to show");
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const auto s = particles.shape[i];
    if (s < 0 || static_cast<std::size_t>(s) >= shapes.shapes.size())
      throw Error("no-such-shape",
                  "particle " + std::to_string(i) + " has shape " + std::to_string(s) + ", but there are " +
                      std::to_string(shapes.shapes.size()) + " shapes",
                  "connect the shapes that the particles were packed with");
    if (!particles.position[i].allFinite() || !std::isfinite(particles.scale[i]) ||
        !particles.color[i].allFinite() || !particles.orientation[i].coeffs().allFinite() ||
        particles.orientation[i].norm() < 1e-9)
      throw Error("bad-number", "particle " + std::to_string(i) +
                                    " has a position, orientation, scale or colour that is no number");
  }
  return std::make_unique<Heap>(particles, shapes);
}

}  // namespace terrazzo
