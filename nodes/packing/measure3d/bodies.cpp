#include "nodes/packing/measure3d/bodies.h"

#include <fmt/format.h>

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/geometry/periodic.h"

namespace terrazzo::measure3d {
namespace {

// Sets the axes from the covariance of the positions in the body.
void set_axes(Body& body, const Mat3& covariance) {
  const auto solver = eigen_axes(covariance);
  for (int k = 0; k < 3; ++k) {
    body.axes[k] = 2 * std::sqrt(5 * std::max(0.0, solver.eigenvalues()[2 - k]));
    Vec3 d = solver.eigenvectors().col(2 - k);
    if (d.z() < 0 || (d.z() == 0 && (d.y() < 0 || (d.y() == 0 && d.x() < 0)))) d = -d;
    body.directions.col(k) = d;
  }
}

struct Moments {
  double volume = 0, surface = 0;
  Vec3 center = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
};

// By tetrahedra between the origin and each triangle.
Moments moments_of(const Mesh& mesh) {
  Moments m;
  Mat3 second = Mat3::Zero();
  Vec3 first = Vec3::Zero();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double six = a.dot(b.cross(c));
    const Vec3 sum = a + b + c;
    m.volume += six / 6;
    first += six / 24 * sum;
    second += six / 120 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  m.surface = mesh_surface_area(mesh);
  if (m.volume > 0) {
    m.center = first / m.volume;
    m.covariance = second / m.volume - m.center * m.center.transpose();
  }
  return m;
}

}  // namespace

std::vector<Body> bodies_of(const Particles& particles, const Shapes& shapes, const Work& work) {
  if (!particles.box.allFinite() || !(particles.box.minCoeff() > 0))
    throw Error("bad-box", "the particles' box has an edge that is not positive and finite");
  std::vector<Moments> moments(shapes.shapes.size());
  std::vector<char> known(shapes.shapes.size(), 0);
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const std::size_t s = particles.shape[i];
    if (particles.shape[i] < 0 || s >= shapes.shapes.size())
      throw Error("no-such-shape",
                  fmt::format("particle {} has shape {}, but there are {} shapes", i, particles.shape[i],
                              shapes.shapes.size()),
                  "connect the shapes of these particles");
    if (known[s]) continue;
    known[s] = 1;
    moments[s] = moments_of(shapes.shapes[s].mesh);
    if (!(moments[s].volume > 0) || !moments[s].covariance.allFinite())
      throw Error("bad-mesh", fmt::format("shape '{}' encloses no volume", shapes.shapes[s].name),
                  "use a watertight mesh with outward triangles");
  }
  std::vector<Body> out(particles.count());
  work.parallel(out.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Moments& m = moments[particles.shape[i]];
      const double s = particles.scale[i];
      const Mat3 turn = particles.orientation[i].toRotationMatrix();
      Body& b = out[i];
      b.index = i;
      b.cls = particles.cls[i];
      b.is_void = particles.is_void(i);
      b.volume = m.volume * s * s * s;
      b.surface = m.surface * s * s;
      b.center = wrap_point(particles.position[i] + turn * (s * m.center), particles.box);
      set_axes(b, s * s * turn * m.covariance * turn.transpose());
    }
  });
  return out;
}

namespace {

struct LabelSums {
  double voxels = 0;
  Vec3 cosine = Vec3::Zero(), sine = Vec3::Zero();
  Vec3 first = Vec3::Zero();  // of positions relative to `near`, mm
  Mat3 second = Mat3::Zero();
  Vec3 near = Vec3::Zero();  // a point near the center, mm
  bool cut = false;
};

// The labels that occur, in order, and where each stands among them.
struct LabelSlots {
  std::vector<std::int32_t> labels;
  std::vector<std::int32_t> slot;  // by label, −1 if it does not occur

  explicit LabelSlots(const std::vector<std::int32_t>& ids) {
    constexpr std::int32_t kMost = 100'000'000;
    std::int32_t last = -1;
    for (const std::int32_t id : ids) last = std::max(last, id);
    if (last >= kMost)
      throw Error("too-many-labels",
                  fmt::format("the volume contains the label {}; at most {} is supported", last, kMost - 1),
                  "renumber the labels");
    slot.assign(last + 1, -1);
    for (const std::int32_t id : ids)
      if (id >= 0) slot[id] = 0;
    for (std::size_t id = 0; id < slot.size(); ++id)
      if (slot[id] == 0) {
        slot[id] = labels.size();
        labels.push_back(id);
      }
  }
};

// Finds a point near the center of each body, and whether it is cut.
template <class Visit>
void find_near_points(std::vector<LabelSums>& sums, const Raster& raster, const Vec3& edge, Visit&& visit) {
  const Vec3i& n = raster.box.size;
  // A mean direction on a circle for each axis gives a point near the center of a body that wraps.
  std::vector<double> cosine[3], sine[3];
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < n[a]; ++i) {
      const double angle = 2 * M_PI * (i + 0.5) / n[a];
      cosine[a].push_back(std::cos(angle));
      sine[a].push_back(std::sin(angle));
    }
  visit([&](LabelSums& s, const Vec3i& v) {
    ++s.voxels;
    for (int a = 0; a < 3; ++a) {
      const std::size_t i = v[a];
      s.cosine[a] += cosine[a][i];
      s.sine[a] += sine[a][i];
      if (!raster.box.periodic && (v[a] == 0 || v[a] == n[a] - 1)) s.cut = true;
    }
  });
  for (LabelSums& s : sums)
    for (int a = 0; a < 3; ++a) {
      const double turn = std::atan2(s.sine[a], s.cosine[a]) / (2 * M_PI);
      // A body that fills a circle evenly has no mean direction; any point will do.
      s.near[a] = raster.box.periodic ? (turn - std::floor(turn)) * edge[a] : 0.5 * edge[a];
    }
}

// Volume, center and axes.
void set_measures(Body& b, const LabelSums& s, const Raster& raster, const Vec3& edge) {
  b.cut = s.cut;
  b.volume = s.voxels * raster.voxel_volume();
  const Vec3 mean = s.first / s.voxels;
  b.center = s.near + mean;
  if (raster.box.periodic) b.center = wrap_point(b.center, edge);
  b.center += raster.box.corner;
  Mat3 covariance = s.second / s.voxels - mean * mean.transpose();
  covariance += (raster.box.spacing.cwiseAbs2() / 12).asDiagonal();  // of the voxels themselves
  set_axes(b, covariance);
}

}  // namespace

std::vector<Body> bodies_of(const Raster& raster, const Particles* particles, const Work& work) {
  const Vec3i& n = raster.box.size;
  const Vec3& spacing = raster.box.spacing;
  const Vec3 edge = n.cast<double>().cwiseProduct(spacing);
  const LabelSlots known(raster.ids);
  std::vector<LabelSums> sums(known.labels.size());
  const auto visit = [&](auto&& body) {
    std::size_t at = 0;
    for (int z = 0; z < n.z(); ++z) {
      work.check();
      for (int y = 0; y < n.y(); ++y)
        for (int x = 0; x < n.x(); ++x, ++at)
          if (const std::int32_t id = raster.ids[at]; id >= 0) body(sums[known.slot[id]], Vec3i(x, y, z));
    }
  };
  find_near_points(sums, raster, edge, visit);
  visit([&](LabelSums& s, const Vec3i& v) {
    Vec3 d = (v.cast<double>() + Vec3::Constant(0.5)).cwiseProduct(spacing) - s.near;
    if (raster.box.periodic) d = nearest_image(d, edge);
    s.first += d;
    s.second += d * d.transpose();
  });
  std::vector<Body> out(sums.size());
  for (std::size_t k = 0; k < sums.size(); ++k) {
    Body& b = out[k];
    b.index = known.labels[k];
    if (particles) {
      const std::size_t p = known.labels[k];
      b.cls = particles->cls[p];
      b.is_void = particles->is_void(p);
    }
    set_measures(b, sums[k], raster, edge);
  }
  return out;
}

}  // namespace terrazzo::measure3d
