#include "nodes/packing/cells/grow.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/indices.h"
#include "nodes/packing/cells/growing_body.h"
#include "nodes/packing/cells/separating_plane.h"
#include "nodes/packing/rigid/neighbors.h"
#include "runtime/random.h"

namespace terrazzo::tessellation {
namespace {

constexpr std::uint64_t kJointWidths = 0x6a6f696e7473;
constexpr double kReach = 1.8;    // neighbors are those whose bounding spheres meet when enlarged by this
constexpr int kRounds = 60;       // of moving the planes
constexpr double kEnough = 0.01;  // relative shortfall of a volume that needs no more rounds
constexpr int kRepeats = 4;       // of correcting the volume of a cut mesh
constexpr int kFewRepeats = 1;    // the same once the work is used up
constexpr double kSeparation = 14000;              // effort to find the direction of a plane, about
constexpr double kSharpen = 1.15, kSharpest = 60;  // powers of rounded edges
constexpr double kWidest = 0.4;                    // gap of a pair, in the smaller radius
constexpr double kMove = 0.25;  // how far, relative to the difference of the factors of growth
constexpr double kInside =
    0.02;  // smallest distance of a plane from a center, relative to the particle's radius

struct Contact {
  std::int32_t a, b;
  int plane_a, plane_b;
  double apart;  // distance of the centers along the normal, mm
  double gap;    // mm
  double lead;   // difference of the squared extents of a and b along the normal, mm²
};

double extent_along(const Mesh& mesh, const Vec3& direction) {
  double most = -1e300;
  for (const Vec3& v : mesh.vertices) most = std::max(most, direction.dot(v));
  return most;
}

class Growth {
 public:
  Growth(const GrowthShapes& shapes, const Particles& packed, const std::vector<double>& volume,
         const GrowOptions& options, Effort& effort, const Work& work)
      : packed_(packed), options_(options), effort_(effort), work_(work), bodies_(packed.count()) {
    prepare(shapes, volume);
    place_planes();
  }
  Grown run();

 private:
  const Particles& packed_;
  const GrowOptions& options_;
  Effort& effort_;
  const Work& work_;
  std::vector<GrowingBody> bodies_;
  std::vector<Contact> contacts_;

  void prepare(const GrowthShapes& shapes, const std::vector<double>& volume);
  void place_planes();
  double clamped(double offset, const GrowingBody& a, const GrowingBody& b, double apart) const;
  void separate_from_images(std::size_t i);
  void change_pressures(double step);
  void move_planes();
  double worst_shortfall(std::vector<double>& reached, const Work& work);
  void charge();
};

void Growth::prepare(const GrowthShapes& shapes, const std::vector<double>& volume) {
  work_.part(0, 0.1).parallel(bodies_.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      GrowingBody& b = bodies_[i];
      const GrowthShape& shape = shapes.of(i);
      b.mesh = shape.mesh;
      const Mat3 turn = packed_.scale[i] * packed_.orientation[i].toRotationMatrix();
      transform(b.mesh, turn, Vec3::Zero());
      b.radius = mesh_bounding_radius(b.mesh);
      b.outposts = shape.outposts;
      for (Vec3& p : b.outposts) p = turn * p;
      b.wanted = volume[i];
      for (const Triangle& t : b.mesh.triangles)
        b.wedges.push_back(b.mesh.vertices[t[0]].dot(b.mesh.vertices[t[1]].cross(b.mesh.vertices[t[2]])));
    }
  });
}

// Keeps a plane at a distance from both centers. Centers too close for that share what there is.
double Growth::clamped(double offset, const GrowingBody& a, const GrowingBody& b, double apart) const {
  const double low = kInside * a.radius, high = apart - kInside * b.radius;
  return low < high ? std::clamp(offset, low, high) : apart * a.radius / (a.radius + b.radius);
}

// Between a body and its images one box edge away on both sides of each axis.
void Growth::separate_from_images(std::size_t i) {
  GrowingBody& body = bodies_[i];
  for (int axis = 0; axis < 3; ++axis) {
    const double edge = packed_.box[axis];
    if (2 * kReach * body.radius < edge) continue;
    double low = 0, high = 0;
    for (const Vec3& v : body.mesh.vertices) {
      low = std::min(low, v[axis]);
      high = std::max(high, v[axis]);
    }
    const double room = 0.5 * (edge - (high - low) - options_.gap);
    body.planes.push_back({Vec3::Unit(axis), high + room, -1});
    body.planes.push_back({-Vec3::Unit(axis), room - low, -1});
  }
}

void Growth::place_planes() {
  std::vector<double> reach;
  for (GrowingBody& b : bodies_) {
    b.reach = std::min(kReach * b.radius, 0.499 * packed_.box.minCoeff());
    reach.push_back(b.reach);
  }
  const auto pairs = packing::near_pairs(packed_.box, packed_.position, reach,
                                         (1 + options_.gap_variation) * options_.gap, work_.quiet());
  std::vector<Separation> separations(pairs.size());
  effort_.used += kSeparation * static_cast<double>(pairs.size());
  work_.part(0.1, 0.4).parallel(pairs.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const GrowingBody &a = bodies_[pairs[k].a], &b = bodies_[pairs[k].b];
      const Vec3 between = packing::offset_of(pairs[k], packed_.box, packed_.position);
      Separation& s = separations[k] = widest_separation(a.outposts, b.outposts, between);
      s.end = extent_along(a.mesh, s.normal);
      s.start = s.normal.dot(between) - extent_along(b.mesh, -s.normal);
    }
  });
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Vec3 between = packing::offset_of(pairs[k], packed_.box, packed_.position);
    Separation s = separations[k];
    GrowingBody &a = bodies_[pairs[k].a], &b = bodies_[pairs[k].b];
    double apart = s.normal.dot(between);
    double gap = std::min(options_.gap, kWidest * std::min(a.radius, b.radius));
    if (options_.gap_variation > 0)
      gap *= 1 + options_.gap_variation * Random(options_.seed, kJointWidths, k).uniform(-1, 1);
    if (apart < 2 * kInside * (a.radius + b.radius) + gap) {  // the plane would miss a center
      s.normal = between.normalized();
      apart = between.norm();
      s.end = s.start = apart * a.radius / (a.radius + b.radius);
      gap = std::min(gap, 0.5 * apart);
    }
    const double extent_a = s.end, extent_b = apart - s.start;
    contacts_.push_back({pairs[k].a, pairs[k].b, count_of(a.planes), count_of(b.planes), apart, gap,
                         extent_a * extent_a - extent_b * extent_b});
    a.planes.push_back({s.normal, 0, pairs[k].b});
    b.planes.push_back({-s.normal, 0, pairs[k].a});
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) separate_from_images(i);
  if (options_.roundness > 0)
    for (GrowingBody& b : bodies_) b.set_power(3 / options_.roundness);
}

// A particle that had to grow more than others presses more.
void Growth::change_pressures(double step) {
  double mean = 0;
  for (const GrowingBody& b : bodies_) mean += b.growth / static_cast<double>(bodies_.size());
  for (GrowingBody& b : bodies_) b.pressure += step * std::clamp(b.growth / mean - 1, -0.3, 0.3);
}

// Sets the planes as those of a power diagram whose seeds have the extents of the bodies as radii and the
// pressures in their weights. Bodies that touch meet where they touch.
void Growth::move_planes() {
  for (const Contact& c : contacts_) {
    GrowingBody &a = bodies_[c.a], &b = bodies_[c.b];
    const double apart = c.apart - c.gap;  // of the two faces of the gap, as if it were not there
    const double offset = clamped(
        0.5 * (apart + (c.lead + (a.pressure - b.pressure) * a.radius * b.radius) / apart), a, b, apart);
    a.planes[c.plane_a].offset = offset;
    b.planes[c.plane_b].offset = apart - offset;
  }
}

// Enlarges the bodies between the planes as they are.
double Growth::worst_shortfall(std::vector<double>& reached, const Work& work) {
  work.parallel(bodies_.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      GrowingBody& body = bodies_[i];
      body.sort_planes();
      reached[i] = solve_growth(body, limits_of(body));
      // Without room for round edges, they become sharper.
      if (body.power > 0 && reached[i] < (1 - kEnough) * body.wanted)
        body.set_power(body.power < kSharpest ? kSharpen * body.power : 0);
    }
  });
  double worst = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    worst = std::max(worst, 1 - reached[i] / bodies_[i].wanted);
  return worst;
}

// Adds what the bodies did since the last time.
void Growth::charge() {
  for (GrowingBody& b : bodies_) effort_.used += std::exchange(b.work, 0);
}

Grown Growth::run() {
  Grown out;
  std::vector<double> reached(bodies_.size());
  for (int round = 0;; ++round) {
    move_planes();
    const double worst = worst_shortfall(
        reached, work_.part(0.4 + 0.5 * round / (kRounds + 1), 0.4 + 0.5 * (round + 1) / (kRounds + 1)));
    charge();
    if (worst < kEnough || round == kRounds || effort_.spent()) break;
    change_pressures(kMove / (1 + 0.2 * round));
  }
  const int repeats = effort_.spent() ? kFewRepeats : kRepeats;
  out.meshes.resize(bodies_.size());
  std::vector<GrownSurface> surfaces(bodies_.size());
  work_.part(0.9, 1).parallel(bodies_.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      CutBody cut = cut_to_volume(bodies_[i], reached[i] == bodies_[i].wanted, repeats);
      surfaces[i] = surface_of(cut, bodies_[i]);
      out.meshes[i] = std::move(cut.mesh);
    }
  });
  double all = 0;
  for (const GrownSurface& s : surfaces) {
    out.flat += s.flat;
    all += s.all;
  }
  out.flat /= all;
  charge();
  return out;
}

}  // namespace

Grown grow(const GrowthShapes& shapes, const Particles& packed, const std::vector<double>& volume,
           const GrowOptions& options, Effort& effort, const Work& work) {
  return Growth(shapes, packed, volume, options, effort, work).run();
}

}  // namespace terrazzo::tessellation
