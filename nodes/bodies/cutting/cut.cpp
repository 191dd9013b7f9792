#include "nodes/bodies/cutting/cut.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"

namespace terrazzo::section {

void check_particles(const Particles& particles, const Shapes& shapes) {
  if (particles.count() == 0)
    throw Error("no-particles", "there are no particles to cut", "check the result of the packing");
  if (shapes.shapes.empty())
    throw Error("no-shapes", "there are no shapes", "connect the shapes used in the packing");
  if (!particles.box.allFinite() || !(particles.box.minCoeff() > 0))
    throw Error("bad-box",
                fmt::format("the particles' box must have positive edges; it is {:g} × {:g} × {:g} mm",
                            particles.box.x(), particles.box.y(), particles.box.z()));
  const std::size_t n = particles.count();
  if (particles.shape.size() != n || particles.cls.size() != n || particles.orientation.size() != n ||
      particles.scale.size() != n || particles.color.size() != n)
    throw Error("bad-particle", "the particles' columns differ in length");
  for (std::size_t i = 0; i < n; ++i) {
    const int shape = particles.shape[i];
    if (shape < 0 || static_cast<std::size_t>(shape) >= shapes.shapes.size())
      throw Error("no-such-shape",
                  fmt::format("particle {} has shape {}, but there are only {} shapes", i, shape,
                              shapes.shapes.size()),
                  "connect the shapes used in the packing");
    if (!particles.position[i].allFinite() || !particles.orientation[i].coeffs().allFinite() ||
        !(particles.scale[i] > 0) || !std::isfinite(particles.scale[i]) ||
        !(particles.orientation[i].norm() > 0.5))
      throw Error("bad-particle",
                  fmt::format("particle {} has an invalid position, orientation or scale", i));
  }
}

namespace {

class Cutter {
 public:
  Cutter(const Particles& particles, const Shapes& shapes, const SectionLayout& layout)
      : particles_(particles), shapes_(shapes), layout_(layout) {
    for (const Shape& s : shapes.shapes) {
      double radius = 0;
      for (const Vec3& v : s.mesh.vertices) radius = std::max(radius, v.norm());
      radii_.push_back(radius);
    }
  }

  void cut(int section, int particle, std::vector<Cut>& out) const {
    const SectionPlane& plane = layout_.planes[section];
    const double radius = radii_[particles_.shape[particle]] * particles_.scale[particle];
    // Only periodic images within the window's bounding box, grown by the radius, can reach the window.
    Vec3 lo = plane.origin, hi = plane.origin;
    const Vec3 edges[2] = {plane.frame.col(0) * layout_.width, plane.frame.col(1) * layout_.height};
    for (const Vec3& e : edges) {
      lo += e.cwiseMin(0.0);
      hi += e.cwiseMax(0.0);
    }
    const Vec3& p = particles_.position[particle];
    int first[3], last[3];
    for (int k = 0; k < 3; ++k) {
      first[k] = round_up((lo[k] - radius - p[k]) / particles_.box[k]);
      last[k] = round_down((hi[k] + radius - p[k]) / particles_.box[k]);
      // In a tile, periodic images shifted within the plane repeat the same region.
      if (layout_.tile && plane.frame.col(2)[k] == 0) first[k] = last[k] = 0;
    }
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x)
          cut_image(section, particle, p + Vec3(x, y, z).cwiseProduct(particles_.box) - plane.origin, radius,
                    out);
  }

 private:
  // `at`: the image's position relative to the window's corner.
  void cut_image(int section, int particle, const Vec3& at, double radius, std::vector<Cut>& out) const {
    const Mat3& frame = layout_.planes[section].frame;
    const Vec3 local = frame.transpose() * at;
    if (std::abs(local.z()) > radius) return;
    if (!layout_.tile && (local.x() < -radius || local.y() < -radius || local.x() > layout_.width + radius ||
                          local.y() > layout_.height + radius))
      return;
    const double scale = particles_.scale[particle];
    const Mat3 turned = particles_.orientation[particle].normalized().toRotationMatrix().transpose() * frame;
    const Mesh& mesh = shapes_.shapes[particles_.shape[particle]].mesh;
    for (Region& region : section_profiles(section_loops(mesh, turned, -local.z() / scale))) {
      for (Loop& l : region)
        for (Vec2& v : l) v = v * scale + local.head<2>();
      if (!(region_area(region) > 0)) continue;
      if (layout_.tile) {
        const Vec2 c = region_centroid(region);
        const Vec2 shift(-std::floor(c.x() / layout_.width) * layout_.width,
                         -std::floor(c.y() / layout_.height) * layout_.height);
        if (!shift.isZero(0)) region = translated(std::move(region), shift);
      } else {
        const Extent e = region_extent(region);
        if (e.hi.x() <= 0 || e.hi.y() <= 0 || e.lo.x() >= layout_.width || e.lo.y() >= layout_.height)
          continue;
      }
      out.push_back({section, particle, std::move(region)});
    }
  }

  const Particles& particles_;
  const Shapes& shapes_;
  const SectionLayout& layout_;
  std::vector<double> radii_;
};

}  // namespace

std::vector<Cut> cut_particles(const Particles& particles, const Shapes& shapes, const SectionLayout& layout,
                               const Work& work) {
  const Cutter cutter(particles, shapes, layout);
  const std::size_t n = particles.count(), grain = 64;
  return work.reduce(
      layout.planes.size() * n, grain, std::vector<Cut>{},
      [&](std::size_t begin, std::size_t end) {
        std::vector<Cut> found;
        for (std::size_t i = begin; i < end; ++i) cutter.cut(i / n, i % n, found);
        return found;
      },
      [](std::vector<Cut> all, std::vector<Cut> more) {
        all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
        return all;
      });
}

}  // namespace terrazzo::section
