#include "nodes/bodies/carving/particle_index.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/mesh_distance.h"
#include "nodes/common/geometry/mesh/render_mesh.h"
#include "nodes/data/indices.h"

namespace terrazzo::carving {

void check_shown(const Particles& particles, const Shapes& shapes) {
  if (particles.count() == 0) throw Error("no-particles", "there are no particles to show");
  const double longest = particles.box.maxCoeff();
  if (!(particles.box.minCoeff() > 0) || !std::isfinite(longest))
    throw Error("bad-box", "the particles' box has no volume");
  for (const Shape& s : shapes.shapes)
    for (const Vec3& v : s.mesh.vertices) require_moderate(v.cast<float>());
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const auto s = particles.shape[i];
    if (s < 0 || static_cast<std::size_t>(s) >= shapes.shapes.size())
      throw Error("no-such-shape",
                  "particle " + std::to_string(i) + " has shape " + std::to_string(s) + ", but there are " +
                      std::to_string(shapes.shapes.size()) + " shapes",
                  "connect the shapes used for packing");
    if (!particles.position[i].allFinite() || !std::isfinite(particles.scale[i]) ||
        !particles.color[i].allFinite() || !particles.orientation[i].coeffs().allFinite() ||
        particles.orientation[i].norm() < 1e-9)
      throw Error("bad-number",
                  "particle " + std::to_string(i) +
                      " has an invalid position, orientation, scale or color (NaN or infinite)");
  }
}

namespace {

RayScene::Triangles triangles_of(const Shape& s) {
  RenderMesh m = render_mesh(s);
  RayScene::Triangles t;
  for (const Vec3& p : m.positions) t.positions.push_back(p.cast<float>());
  t.indices = std::move(m.indices);
  return t;
}

}  // namespace

ParticleIndex::Solid::Solid(const Shape& s) : triangles(triangles_of(s)), rays({triangles}, {{}}) {
  double near = std::numeric_limits<double>::infinity();  // squared
  for (const auto& [a, b, c] : s.mesh.triangles)
    near = std::min(near, squared_distance_to_triangle(Vec3::Zero(), s.mesh.vertices[a], s.mesh.vertices[b],
                                                       s.mesh.vertices[c]));
  // A shape's origin may be outside the shape: then there is no inner sphere.
  RayHit hit;
  if (rays.nearest(Vec3f::Zero(), Vec3f(0.3f, 0.5f, 0.81f).normalized(), hit)) inner = near * 0.9998;
}

bool ParticleIndex::Solid::holds(const Vec3f& at) const {
  if (at.squaredNorm() < inner) return true;
  const Vec3f direction(0.36f, 0.48f, 0.8f);
  RayHit hit;
  if (!rays.nearest(at, direction, hit)) return false;
  const std::uint32_t* i = &triangles.indices[3 * static_cast<std::size_t>(hit.triangle)];
  const auto& p = triangles.positions;
  return (p[i[1]] - p[i[0]]).cross(p[i[2]] - p[i[0]]).dot(direction) > 0;  // the ray leaves
}

const ParticleIndex::Solid& ParticleIndex::solid(std::int32_t shape) const {
  Lazy& lazy = solids_[shape];
  std::call_once(lazy.once, [&] { lazy.solid.emplace(shapes_.shapes[shape]); });
  return *lazy.solid;
}

void ParticleIndex::list_in_cells(std::int32_t particle, const Vec3f& at,
                                  std::vector<std::vector<Entry>>& lists) const {
  const Vec3f size = box_.cwiseQuotient(cells_.cast<float>());
  const float radius = outer_[particle];
  Vec3i low, high;
  for (int k = 0; k < 3; ++k) {
    low[k] = round_down((at[k] - radius) / size[k]);
    high[k] = round_down((at[k] + radius) / size[k]);
  }
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) {
        const Vec3i cell(x, y, z);
        Vec3f center = at;
        std::size_t list = 0;
        for (int k = 2; k >= 0; --k) {
          const int periods = round_down(float(cell[k]) / float(cells_[k]));
          center[k] -= float(periods) * box_[k];
          list = list * cells_[k] + (cell[k] - periods * cells_[k]);
        }
        // Skip cells at the corners of the box that the sphere does not reach.
        float square = 0;
        for (int k = 0; k < 3; ++k) {
          const float lo = float(cell[k]) * size[k], d = std::max({lo - at[k], at[k] - lo - size[k], 0.0f});
          square += d * d;
        }
        if (square <= radius * radius) lists[list].push_back({particle, center});
      }
}

void ParticleIndex::fill_cells(const Particles& particles) {
  std::vector<std::vector<Entry>> lists(cells_.prod());
  for (std::size_t i = 0; i < particles.count(); ++i)
    list_in_cells(i, particles.position[i].cast<float>(), lists);
  for (const auto& l : lists) {
    first_.push_back(entries_.size());
    entries_.insert(entries_.end(), l.begin(), l.end());
  }
  first_.push_back(entries_.size());
}

ParticleIndex::ParticleIndex(const Particles& particles, const Shapes& shapes)
    : box_(particles.box.cast<float>()),
      shapes_(shapes),
      solids_(shapes.shapes.size()),
      shape_(particles.shape) {
  check_shown(particles, shapes);
  std::vector<double> radius;  // of the shapes at scale 1
  for (const Shape& s : shapes.shapes) radius.push_back(mesh_bounding_radius(s.mesh));
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const double scale = std::abs(particles.scale[i]);
    outer_.push_back(scale * radius[particles.shape[i]] * 1.0001);
    const Mat3 turn = particles.orientation[i].normalized().toRotationMatrix();
    to_shape_.push_back((turn.transpose() / std::max(scale, 1e-30)).cast<float>());
  }
  // About two cells per mean diameter, limited to the memory of a few million cells.
  const double volume = particles.box.prod(), spacing = 0.5 * std::cbrt(volume / particles.count());
  for (int k = 0; k < 3; ++k) cells_[k] = std::clamp<int>(particles.box[k] / spacing, 1, 160);
  fill_cells(particles);
  for (auto& r : outer_) r *= r;
}

bool ParticleIndex::holds(std::int32_t particle, const Vec3f& from_center) const {
  if (from_center.squaredNorm() > outer_[particle]) return false;
  return solid(shape_[particle]).holds(to_shape_[particle] * from_center);
}

int ParticleIndex::at(const Vec3f& mm) const {
  Vec3f p;
  std::size_t cell = 0;
  for (int k = 2; k >= 0; --k) {
    p[k] = mm[k] - std::floor(mm[k] / box_[k]) * box_[k];
    const int c = std::clamp<int>(p[k] / box_[k] * float(cells_[k]), 0, cells_[k] - 1);
    cell = cell * cells_[k] + c;
  }
  for (std::uint32_t e = first_[cell]; e < first_[cell + 1]; ++e)
    if (holds(entries_[e].particle, p - entries_[e].center)) return entries_[e].particle;
  return -1;
}

}  // namespace terrazzo::carving
