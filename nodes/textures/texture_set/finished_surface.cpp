#include "nodes/textures/texture_set/finished_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/geometry/mesh/render_mesh.h"
#include "nodes/data/indices.h"

namespace terrazzo::texture_set {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kLayers = 3;  // of loose particles; below them is the ground

}  // namespace

FinishedSurface::FinishedSurface(const Particles& particles, const Shapes& shapes,
                                 const section::SectionLayout& layout, const Finish& finish, const Work& work)
    : particles_(particles),
      plane_(layout.planes.at(0)),
      width_(layout.width),
      height_(layout.height),
      finish_(finish),
      index_(particles, shapes) {
  unit_ = static_cast<float>(particles.box.maxCoeff());
  period_ = particles.box.dot(plane_.frame.col(2).cwiseAbs());
  if (finish.kind == FinishKind::Broken)
    face_.emplace(width_, height_, layout.pixel_size, finish.grain, finish.relief, finish.seed, work);
  for (const Vec3& p : particles.position) {
    const Vec3 local = plane_.frame.transpose() * (p - plane_.origin);
    center_.push_back(local.z());
    face_at_.push_back(face_ ? face_->at(local.x(), local.y()) : 0);
  }
  find_depths(shapes);
  if (finish.kind != FinishKind::Polished || particles.void_count() > 0) add_images(shapes, work);
}

// How far up and down columns have to be searched.
void FinishedSurface::find_depths(const Shapes& shapes) {
  std::vector<double> far;
  for (const Shape& s : shapes.shapes) {
    double most = 0;
    for (const Vec3& v : s.mesh.vertices) most = std::max(most, v.norm());
    far.push_back(most);
  }
  double largest = 0, largest_void = 0;
  for (std::size_t i = 0; i < particles_.count(); ++i) {
    radius_.push_back(far[particles_.shape[i]] * particles_.scale[i]);
    double& most = particles_.is_void(i) ? largest_void : largest;
    most = std::max(most, radius_.back());
  }
  if (finish_.kind == FinishKind::Loose) {
    top_ = largest;
    bottom_ = -kLayers * 2 * largest;
    return;
  }
  if (face_) top_ = face_->highest() + largest;
  bottom_ = (face_ ? face_->lowest() : -std::abs(finish_.relief)) -
            2 * std::max(largest_void, face_ || finish_.relief < 0 ? largest : 0.0);
}

void FinishedSurface::add_images(const Shapes& shapes, const Work& work) {
  std::vector<carving::RayScene::Triangles> meshes;
  for (const Shape& s : shapes.shapes) {
    carving::RayScene::Triangles t;
    const RenderMesh m = render_mesh(s);
    for (const Vec3& p : m.positions) t.positions.push_back(p.cast<float>());
    t.indices = m.indices;
    meshes.push_back(std::move(t));
  }
  Eigen::AlignedBox3d slab;
  for (const double z : {top_, bottom_}) {
    slab.extend(plane_.origin + z * plane_.frame.col(2));
    slab.extend(plane_.origin + plane_.frame * Vec3(width_, height_, z));
  }
  const bool whole_stones = face_ || finish_.kind == FinishKind::Loose;
  std::vector<carving::RayScene::Instance> instances, whole;
  for (std::size_t i = 0; i < particles_.count(); ++i) {
    if (i % 1024 == 0) work.check();
    const Vec3& p = particles_.position[i];
    Vec3i lo, hi;
    for (int k = 0; k < 3; ++k) {
      lo[k] = round_up((slab.min()[k] - radius_[i] - p[k]) / particles_.box[k]);
      hi[k] = round_down((slab.max()[k] + radius_[i] - p[k]) / particles_.box[k]);
    }
    carving::RayScene::Instance instance;
    instance.mesh = particles_.shape[i];
    instance.linear =
        (particles_.orientation[i].normalized().toRotationMatrix() * (particles_.scale[i] / unit_))
            .cast<float>();
    for (int z = lo.z(); z <= hi.z(); ++z)
      for (int y = lo.y(); y <= hi.y(); ++y)
        for (int x = lo.x(); x <= hi.x(); ++x) {
          instance.offset = ((p + Vec3(x, y, z).cwiseProduct(particles_.box)) / unit_).cast<float>();
          instances.push_back(instance);
          const double height =
              plane_.frame.col(2).dot(p + Vec3(x, y, z).cwiseProduct(particles_.box) - plane_.origin);
          if (whole_stones && !particles_.is_void(i) && height < face_at_[i]) whole.push_back(instance);
        }
  }
  if (!instances.empty()) scene_ = std::make_unique<carving::RayScene>(meshes, instances);
  if (!whole.empty()) whole_ = std::make_unique<carving::RayScene>(meshes, whole);
}

// Below which the material at this height stays.
double FinishedSurface::level(int particle, double height, double face) const {
  const bool worn = finish_.kind == FinishKind::Honed || finish_.kind == FinishKind::Weathered;
  if (particle < 0) return face_ ? face : worn && finish_.relief > 0 ? -finish_.relief : 0;
  if (particles_.is_void(particle)) return -kNever;
  if (!face_) return worn && finish_.relief < 0 ? finish_.relief : 0;
  // The image of the particle that contains the point is the nearest one.
  const double center = center_[particle];
  const double image = center - std::round((center - height) / period_) * period_;
  return image < face_at_[particle] ? kNever : -kNever;
}

double FinishedSurface::next_below(const carving::RayScene* scene, const Vec3& foot, double from) const {
  const Vec3 normal = plane_.frame.col(2);
  carving::RayHit hit;
  const Vec3f start = ((foot + from * normal) / double{unit_}).cast<float>();
  if (!scene || !scene->nearest(start, (-normal).cast<float>(), hit)) return -kNever;
  return from - double{hit.distance * unit_};
}

FinishedSurface::Point FinishedSurface::at(double u, double v) const {
  const double below = 1e-5 * double{unit_};  // where the material under a boundary is looked up
  const Vec3 foot = plane_.origin + plane_.frame * Vec3(u, v, 0);
  const auto material = [&](double z) {
    return index_.at((foot + (z - below) * plane_.frame.col(2)).cast<float>());
  };
  if (finish_.kind == FinishKind::Loose) {
    const double stone = next_below(whole_.get(), foot, top_);
    if (stone < bottom_) return {static_cast<float>(bottom_), -1, false};
    return {static_cast<float>(stone), material(stone), false};
  }
  double z = 0, face = 0;
  if (face_) {
    z = face = face_->at(u, v);
    const double stone = next_below(whole_.get(), foot, top_);
    if (stone > face) return {static_cast<float>(stone), material(stone), false};
  }
  for (int step = 0; step < 256 && z >= bottom_; ++step) {
    const int particle = material(z);
    const double stays = level(particle, z, face);
    if (stays >= z) return {static_cast<float>(z), particle, step == 0};
    const double next = next_below(scene_.get(), foot, z - below);
    if (stays > next) return {static_cast<float>(stays), particle, true};
    z = next;
  }
  return {static_cast<float>(std::max(z, bottom_)), -1, false};
}

}  // namespace terrazzo::texture_set
