#include "nodes/bodies/carving/hollows.h"

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/bodies/carving/particle_index.h"
#include "nodes/data/indices.h"

namespace terrazzo::carving {
namespace {
constexpr std::size_t kMost = 4'000'000;  // about 300 bytes each
}

std::vector<VoidImage> void_images(const Voids& voids, const Eigen::AlignedBox3f& bounds) {
  const Particles& particles = *voids.particles;
  check_shown(particles, *voids.shapes);
  std::vector<double> radius;
  for (const Shape& s : voids.shapes->shapes) {
    double far = 0;
    for (const Vec3& v : s.mesh.vertices) far = std::max(far, v.norm());
    radius.push_back(far);
  }
  const Vec3 box = particles.box;
  const double unit = box.maxCoeff() * voids.repeat;  // mm per world unit
  const Mat3 turn = voids.placement.turn.cast<double>();
  const Vec3 shift = voids.placement.shift.cast<double>().cwiseProduct(box);
  Eigen::AlignedBox3d reach;  // of the body, in the material
  for (int corner = 0; corner < 8; ++corner)
    reach.extend(turn * bounds.corner(static_cast<Eigen::AlignedBox3f::CornerType>(corner)).cast<double>() *
                     unit +
                 shift);
  std::vector<VoidImage> images;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (!particles.is_void(i)) continue;
    const double r = radius[particles.shape[i]] * particles.scale[i];
    const Mat3 rotation = turn.transpose() * particles.orientation[i].normalized().toRotationMatrix();
    Vec3i lo, hi;
    for (int k = 0; k < 3; ++k) {
      lo[k] = round_up((reach.min()[k] - r - particles.position[i][k]) / box[k]);
      hi[k] = round_down((reach.max()[k] + r - particles.position[i][k]) / box[k]);
    }
    for (int z = lo.z(); z <= hi.z(); ++z)
      for (int y = lo.y(); y <= hi.y(); ++y)
        for (int x = lo.x(); x <= hi.x(); ++x) {
          const Vec3 mm = particles.position[i] + Vec3(x, y, z).cwiseProduct(box) - shift;
          RayScene::Instance instance;
          instance.mesh = particles.shape[i];
          instance.linear = (rotation * (particles.scale[i] / unit)).cast<float>();
          instance.offset = (turn.transpose() * mm / unit).cast<float>();
          if (bounds.squaredExteriorDistance(instance.offset) > r * r / (unit * unit)) continue;
          if (images.size() == kMost)
            throw Error("too-many-particles", "the body cuts more than " + std::to_string(kMost) + " voids",
                        "reduce `repeat`");
          images.push_back({instance, rotation.cast<float>()});
        }
  }
  return images;
}

Hollows::Hollows(const Voids& voids, const Eigen::AlignedBox3f& bounds)
    : voids_(voids),
      mm_per_unit_(static_cast<float>(voids.particles->box.maxCoeff() * voids.repeat)),
      shift_(voids.placement.shift.cwiseProduct(voids.particles->box.cast<float>())) {
  std::vector<RayScene::Instance> instances;
  std::vector<RayScene::Triangles> triangles;
  for (const Shape& s : voids.shapes->shapes) {
    meshes_.emplace_back(s);
    triangles.push_back(meshes_.back().triangles);
  }
  for (const VoidImage& i : void_images(voids, bounds)) {
    instances.push_back(i.instance);
    mesh_of_.push_back(i.instance.mesh);
    turns_.push_back(i.turn);
  }
  if (!instances.empty()) scene_ = std::make_unique<RayScene>(triangles, instances);
}

bool Hollows::holds(const Vec3f& point) const {
  return voids_.holds(voids_.placement.turn * point * mm_per_unit_ + shift_);
}

bool Hollows::nearest(const Vec3f& origin, const Vec3f& direction, HollowHit& out) const {
  RayHit hit;
  if (!scene_ || !scene_->nearest(origin, direction, hit)) return false;
  out.at = hit.distance;
  meshes_[mesh_of_[hit.instance]].normals_at(hit, out.face, out.normal);
  out.face = turns_[hit.instance] * out.face;
  out.normal = turns_[hit.instance] * out.normal;
  out.leaves = out.face.dot(direction) > 0;
  return true;
}

}  // namespace terrazzo::carving
