#include "nodes/bodies/view/bed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/bodies/view/soil.h"
#include "nodes/data/indices.h"
#include "nodes/packing/rigid/statistics.h"
#include "runtime/random.h"

namespace terrazzo::view {
namespace {

constexpr std::uint64_t kPlaceStream = 0x76696577;
constexpr double kMostStones = 4e6;
constexpr double kRounding = 1e-6;  // of heights, in heights of the box

void require_few(const Particles& particles, const Vec2& picture, double margin) {
  constexpr int kCopies = 2;  // of each along z
  const double across = (picture.x() + 2 * margin) / particles.box.x() + 1;
  const double down = (picture.y() + 2 * margin) / particles.box.y() + 1;
  const double stones = across * down * kCopies * particles.count();
  if (!(stones <= kMostStones))
    throw Error("too-many-particles",
                fmt::format("up to {:.3g} stones would lie in a picture of {:g} × {:g} mm; the limit is {:g}",
                            stones, picture.x(), picture.y(), kMostStones),
                "reduce width and height")
        .parameter("width");
}

}  // namespace

bool has_top(const Particles& particles, const Shapes& shapes) {
  const double rounding = kRounding * particles.box.z();
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (particles.is_void(i)) continue;
    const auto [low, high] = packing::height_range(shapes, particles, i);
    if (low < -rounding || high > particles.box.z() + rounding) return false;
  }
  return true;
}

StoneMeshes::StoneMeshes(const Shapes& shapes) {
  for (const Shape& shape : shapes.shapes) {
    bodies.emplace_back(shape);
    triangles.push_back(bodies.back().triangles);
    double most = 0;
    for (const Vec3& v : shape.mesh.vertices) most = std::max(most, v.norm());
    radius.push_back(most);
  }
}

double StoneMeshes::largest(const Particles& particles) const {
  double most = 0;
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (!particles.is_void(i)) most = std::max(most, 2 * radius[particles.shape[i]] * particles.scale[i]);
  if (!(most > 0))
    throw Error("no-particles", "all particles are voids, so there are no stones to see from above",
                "set view to section");
  return most;
}

std::vector<BedPlace> choose_places(int pictures, const Particles& particles, const Shapes& shapes,
                                    std::uint64_t seed) {
  const Vec3& box = particles.box;
  const bool top = has_top(particles, shapes);
  const double start = Random(seed, kPlaceStream).uniform();
  std::vector<BedPlace> places;
  for (int k = 0; k < pictures; ++k) {
    Random random(seed, kPlaceStream, 1 + k);
    BedPlace place;
    place.height = top ? box.z() : box.z() * (k + start) / pictures;
    place.corner.x() = box.x() * random.uniform();
    place.corner.y() = box.y() * random.uniform();
    places.push_back(place);
  }
  return places;
}

Bed::Bed(const Particles& particles, const StoneMeshes& meshes, const BedPlace& place, const Vec2& picture,
         double margin, const BedSoil* soil, const Work& work)
    : meshes_(meshes),
      origin_(place.corner.x(), place.corner.y(), place.height),
      depth_(particles.box.z()),
      top_(static_cast<float>(meshes.largest(particles))) {
  require_few(particles, picture, margin);
  std::vector<carving::RayScene::Instance> instances;
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (!particles.is_void(i)) add_copies(particles, i, picture, margin, instances);
  if (soil) leave_in_soil(instances, picture, *soil, work);
  scene_ = std::make_unique<carving::RayScene>(meshes.triangles, instances);
}

void Bed::add_copies(const Particles& particles, int particle, const Vec2& picture, double margin,
                     std::vector<carving::RayScene::Instance>& instances) {
  const Vec3& box = particles.box;
  const Vec3 at = particles.position[particle] - origin_;
  const Mat3 turn = particles.orientation[particle].normalized().toRotationMatrix();
  const int x0 = round_up((-margin - at.x()) / box.x());
  const int y0 = round_up((-margin - at.y()) / box.y());
  const int x1 = round_down((picture.x() + margin - at.x()) / box.x());
  const int y1 = round_down((picture.y() + margin - at.y()) / box.y());
  carving::RayScene::Instance instance;
  instance.mesh = particles.shape[particle];
  instance.linear = (turn * particles.scale[particle]).cast<float>();
  const float reach = reach_below(meshes_.triangles[instance.mesh], instance.linear);
  std::vector<double> heights{at.z() - std::ceil(at.z() / box.z()) * box.z()};  // of centers
  if (const double above = heights[0] + box.z(); above < reach - 2 * kRounding * box.z())
    heights.push_back(above);
  for (const double z : heights)
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const Vec3 center(at.x() + x * box.x(), at.y() + y * box.y(), z);
        instance.offset = center.cast<float>();
        instances.push_back(instance);
        stones_.push_back({particle, instance.mesh, turn.cast<float>(),
                           (particles.position[particle] - center).cast<float>(), reach});
      }
}

void Bed::leave_in_soil(std::vector<carving::RayScene::Instance>& instances, const Vec2& picture,
                        const BedSoil& soil, const Work& work) {
  std::vector<float> exposures;
  for (std::size_t i = 0; i < stones_.size(); ++i)
    exposures.push_back(instances[i].offset.z() / stones_[i].reach);
  const float most =
      exposure_of_share(meshes_.triangles, instances, exposures, {picture, soil.cell}, soil.covered, work);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < stones_.size(); ++i) {
    if (exposures[i] > most) continue;
    stones_[kept] = stones_[i];
    instances[kept++] = instances[i];
  }
  stones_.resize(kept);
  instances.resize(kept);
}

bool Bed::below(float x, float y, BedPoint& point) const {
  const Vec3f from(x, y, top_), down(0, 0, -1);
  carving::RayHit hit;
  if (!scene_->nearest(from, down, hit)) return false;
  const Stone& stone = stones_[hit.instance];
  point.stone = static_cast<int>(hit.instance);
  point.at = Vec3f(x, y, top_ - hit.distance);
  meshes_.bodies[stone.mesh].normals_at(hit, point.face, point.normal);
  point.face = stone.turn * point.face;
  point.normal = stone.turn * point.normal;
  return true;
}

bool Bed::hides(const Vec3f& origin, const Vec3f& direction) const { return scene_->any(origin, direction); }

bool Bed::hides(const Vec3f& origin, const Vec3f& direction, float reach) const {
  carving::RayHit hit;
  return scene_->nearest(origin, direction, hit) && hit.distance < reach;
}

Vec3f Bed::in_packing(const BedPoint& point) const {
  if (point.stone < 0) return point.at + origin_.cast<float>();
  return point.at + stones_[point.stone].to_packing;
}

}  // namespace terrazzo::view
