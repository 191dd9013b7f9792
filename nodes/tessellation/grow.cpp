#include "nodes/tessellation/grow.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/directions.h"
#include "nodes/common/geometry/mesh.h"
#include "nodes/packing/neighbors.h"
#include "nodes/packing/simplify.h"
#include "nodes/tessellation/convex_cell.h"
#include "nodes/tessellation/separating_plane.h"
#include "nodes/tessellation/split_edges.h"
#include "runtime/random.h"

namespace terrazzo::tessellation {
namespace {

constexpr std::uint64_t kJointWidths = 0x6a6f696e7473;
constexpr double kReach = 1.8;        // neighbors are those whose bounding spheres meet when enlarged by this
constexpr double kLargest = 4;        // largest factor of growth
constexpr double kLongestEdge = 0.2;  // of meshes, in diameters of the shape
constexpr double kDeviation = 0.005;  // of a simplified shape, in its size
constexpr std::size_t kFewest = 500;  // triangles of a simplified shape
constexpr double kFiner = 1.25;       // factor by which their number rises until the deviation is kept
constexpr int kRounds = 60;           // of moving the planes
constexpr double kEnough = 0.01;      // relative shortfall of a volume that needs no more rounds
constexpr int kRepeats = 4;           // of correcting the volume of a cut mesh
constexpr int kHalvings = 16;
constexpr double kExact = 1e-3;                    // relative error of a volume that needs no correction
constexpr double kNoEdge = 0.003;                  // share of the norm that is left out
constexpr double kSharpen = 1.15, kSharpest = 60;  // powers of rounded edges
constexpr double kWidest = 0.4;                    // gap of a pair, in the smaller radius
constexpr double kMove = 0.25;  // how far, relative to the difference of the factors of growth
constexpr double kInside =
    0.02;  // smallest distance of a plane from a center, relative to the particle's radius

struct Body {
  Mesh mesh;                   // as packed, rotated, about the position
  std::vector<Vec3> outposts;  // its farthest vertices along many directions
  std::vector<double> wedges;  // six times the signed volume of each triangle's tetrahedron with the center
  double radius = 0;           // bounding radius as packed, mm
  double reach = 0;            // no point may be farther from the center, mm
  double wanted = 0;           // mm³
  double growth = 1;           // factor
  double pressure = 0;         // moves its planes outward, in squared radii
  std::vector<Plane> planes;   // in the order of contacts
  std::vector<Plane> nearest;  // the same, nearest first
  double power = 0;            // of the norm that rounds edges between planes; 0: sharp
  double no_edge = 0;          // planes no farther along than this share of the farthest make no edge
  double alone = 1;            // the least share of the farthest plane in a norm of 1
  void set_power(double value) {
    power = value;
    alone =
        power > 0 ? std::pow(static_cast<double>(std::max<std::size_t>(planes.size(), 1)), -1 / power) : 1;
    no_edge = power > 0 ? std::pow(kNoEdge, 1 / power) : 1;
  }
  void sort_planes() {
    nearest = planes;
    std::stable_sort(nearest.begin(), nearest.end(),
                     [](const Plane& a, const Plane& b) { return a.offset < b.offset; });
  }
};

struct Contact {
  std::int32_t a, b;
  int plane_a, plane_b;
  double apart;  // distance of the centers along the normal, mm
  double gap;    // mm
  double lead;   // difference of the squared extents of a and b along the normal, mm²
};

// How far a point is towards the planes, as a norm that is 1 on the body's planes except near their edges,
// where it is larger, and so rounds them. Results below `least` may be smaller than they are.
// `shares` is working memory.
double gauge(const Body& body, const Vec3& v, double least, std::vector<double>& shares) {
  shares.clear();
  const double length = v.norm();
  double largest = std::max(1e-9, least * body.alone);
  for (const Plane& p : body.nearest) {
    // All planes from here on are too far to be reached or to make an edge.
    if (length <= body.no_edge * largest * p.offset) break;
    const double share = p.normal.dot(v) / p.offset;
    shares.push_back(share);
    largest = std::max(largest, share);
  }
  const double shortest = body.no_edge * largest;
  double sum = 0;
  for (const double share : shares)
    if (share > shortest) sum += share == largest ? 1 : std::pow(share / largest, body.power);
  return largest * std::pow(sum, 1 / body.power);
}

// For each vertex the largest factor of growth at which it is still inside all planes.
std::vector<double> limits_of(const Body& body) {
  std::vector<double> limit;
  for (const Vec3& v : body.mesh.vertices) limit.push_back(std::min(kLargest, body.reach / v.norm()));
  if (body.power > 0) {
    std::vector<double> shares;
    for (std::size_t v = 0; v < limit.size(); ++v)
      limit[v] = std::min(limit[v], 1 / gauge(body, body.mesh.vertices[v], 1 / limit[v], shares));
    return limit;
  }
  for (const Plane& p : body.nearest) {
    if (p.offset > body.reach) break;
    for (std::size_t v = 0; v < limit.size(); ++v) {
      const double h = p.normal.dot(body.mesh.vertices[v]);
      if (h * limit[v] > p.offset) limit[v] = p.offset / h;
    }
  }
  return limit;
}

double volume_at(const Body& body, const std::vector<double>& limit, double growth) {
  double six = 0;
  for (std::size_t k = 0; k < body.wedges.size(); ++k) {
    const Triangle& t = body.mesh.triangles[k];
    six += body.wedges[k] * std::min(growth, limit[t[0]]) * std::min(growth, limit[t[1]]) *
           std::min(growth, limit[t[2]]);
  }
  return six / 6;
}

// The factor at which the body has its volume, at most kLargest. Returns the volume.
double solve_growth(Body& body, const std::vector<double>& limits) {
  double low = 0, high = kLargest, at_low = 0;
  double at_high = std::cbrt(volume_at(body, limits, high));
  const double goal = std::cbrt(body.wanted);
  if (at_high <= goal) return body.growth = high, std::pow(at_high, 3);
  double at = body.growth < high ? body.growth : 0.5 * high;  // that of the last round is close
  for (int k = 0; k < 40; ++k) {
    const double reached = std::cbrt(volume_at(body, limits, at));
    if (std::abs(reached - goal) < 1e-6 * goal) break;
    (reached > goal ? high : low) = at;
    (reached > goal ? at_high : at_low) = reached;
    // The cube root of the volume is nearly linear in the factor, except where planes stop the growth.
    const double share = std::clamp((goal - at_low) / (at_high - at_low), 0.1, 0.9);
    at = low + share * (high - low);
  }
  return body.growth = at, body.wanted;
}

struct Surface {
  double flat = 0, all = 0;  // area in contact with neighbors and in total, before edges are rounded, mm²
};

// An enlarged body between its planes.
struct CutBody {
  Mesh mesh;
  std::vector<Vec3> sharp;    // the vertices before edges were rounded
  std::vector<Plane> planes;  // those that limit it
};

// Area of the triangles within `near` of a plane.
Surface surface_of(const CutBody& cut, double near) {
  Surface surface;
  std::vector<std::uint8_t> on(cut.sharp.size());
  std::vector<std::uint8_t> flat(cut.mesh.triangles.size(), 0);
  for (const Plane& p : cut.planes) {
    for (std::size_t v = 0; v < on.size(); ++v) on[v] = p.normal.dot(cut.sharp[v]) > p.offset - near;
    for (std::size_t t = 0; t < flat.size(); ++t) {
      const Triangle& c = cut.mesh.triangles[t];
      flat[t] |= on[c[0]] & on[c[1]] & on[c[2]];
    }
  }
  for (std::size_t t = 0; t < flat.size(); ++t) {
    const Triangle& c = cut.mesh.triangles[t];
    const Vec3& corner = cut.sharp[c[0]];
    const double area = 0.5 * (cut.sharp[c[1]] - corner).cross(cut.sharp[c[2]] - corner).norm();
    surface.all += area;
    if (flat[t]) surface.flat += area;
  }
  return surface;
}

double near_a_plane(const Body& body) { return 1e-9 * body.radius; }

// Cuts the enlarged body at its planes. What lies beyond a plane moves onto it along rays from the center.
// Then rounds the edges.
CutBody cut(const Body& body) {
  CutBody out;
  Mesh& mesh = out.mesh = body.mesh;
  for (Vec3& v : mesh.vertices) v *= body.growth;
  const double near = near_a_plane(body), farthest = body.growth * body.radius;
  for (const Plane& p : body.nearest) {
    if (p.offset > farthest) break;
    double top = -1e300;
    for (const Vec3& v : mesh.vertices) top = std::max(top, p.normal.dot(v));
    if (top <= p.offset + near) continue;
    out.planes.push_back(p);
    split_at_plane(mesh, p.normal, p.offset, near);
    for (Vec3& v : mesh.vertices)
      if (const double h = p.normal.dot(v); h > p.offset) v *= p.offset / h;
  }
  out.sharp = mesh.vertices;
  std::vector<double> shares;
  if (body.power > 0)
    for (Vec3& v : mesh.vertices)
      if (const double far = gauge(body, v, 1, shares); far > 1) v /= far;
  return out;
}

// Cuts the body so that its mesh has the wanted volume. Cutting keeps what triangles across an edge leave out
// of the volume at the vertices.
CutBody cut_to_volume(Body& body, bool reached) {
  CutBody out = cut(body);
  const double wanted = body.wanted;
  double volume = mesh_volume(out.mesh);
  if (!reached && volume <= wanted) return out;
  const auto limits = limits_of(body);
  double low = 0, high = 0;  // factors of growth with too little and too much volume
  double at_low = 0, at_high = 0;
  const auto note = [&] {
    if (volume > wanted)
      high = body.growth, at_high = std::cbrt(volume);
    else
      low = body.growth, at_low = std::cbrt(volume);
  };
  note();
  for (int k = 0; k < kRepeats && std::abs(wanted / volume - 1) >= kExact; ++k) {
    body.wanted *= wanted / volume;
    solve_growth(body, limits);
    out = cut(body);
    volume = mesh_volume(out.mesh);
    note();
  }
  // Where a plane is close to the center, the vertices say too little about the volume.
  for (int k = 0; k < kHalvings && high > low && volume > 1.02 * wanted; ++k) {
    const double share = std::clamp((std::cbrt(wanted) - at_low) / (at_high - at_low), 0.1, 0.9);
    body.growth = low + share * (high - low);
    out = cut(body);
    volume = mesh_volume(out.mesh);
    note();
  }
  return out;
}

// The farthest vertices along directions all around, each once.
std::vector<Vec3> farthest_vertices(const Mesh& mesh) {
  constexpr std::size_t kDirections = 100;
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < kDirections; ++k) {
    const Vec3 u = half_sphere_direction(k, kDirections);
    std::size_t top = 0, bottom = 0;
    double highest = -1e300, lowest = 1e300;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const double h = u.dot(mesh.vertices[v]);
      if (h > highest) highest = h, top = v;
      if (h < lowest) lowest = h, bottom = v;
    }
    found.push_back(top), found.push_back(bottom);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<Vec3> points;
  for (std::size_t v : found) points.push_back(mesh.vertices[v]);
  return points;
}

double extent_along(const Mesh& mesh, const Vec3& direction) {
  double most = -1e300;
  for (const Vec3& v : mesh.vertices) most = std::max(most, direction.dot(v));
  return most;
}

class Growth {
 public:
  Growth(const Shapes& shapes, const Particles& packed, const std::vector<double>& volume,
         const GrowOptions& options, const Work& work)
      : packed_(packed), options_(options), work_(work), bodies_(packed.count()) {
    prepare(shapes, volume);
    place_planes();
  }
  Grown run();

 private:
  const Particles& packed_;
  const GrowOptions& options_;
  const Work& work_;
  std::vector<Body> bodies_;
  std::vector<Contact> contacts_;

  void prepare(const Shapes& shapes, const std::vector<double>& volume);
  void place_planes();
  double clamped(double offset, const Body& a, const Body& b, double apart) const;
  void separate_from_images(std::size_t i);
  void change_pressures(double step);
  void move_planes();
};

void Growth::prepare(const Shapes& shapes, const std::vector<double>& volume) {
  std::vector<Mesh> fine(shapes.shapes.size());
  std::vector<std::vector<Vec3>> outposts(fine.size());
  for (std::int32_t s : packed_.shape)
    if (fine[s].vertices.empty()) {
      // Each particle gets a mesh of its own, so it should have few triangles.
      fine[s] = packing::simplified(shapes.shapes[s].mesh, kDeviation * shapes.shapes[s].size(),
                                    work_.quiet(), kFewest, kFiner)
                    .mesh;
      split_long_edges(fine[s], kLongestEdge * std::cbrt(6 / std::numbers::pi * shapes.shapes[s].volume));
      outposts[s] = farthest_vertices(fine[s]);
    }
  work_.part(0, 0.1).parallel(bodies_.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Body& b = bodies_[i];
      b.mesh = fine[packed_.shape[i]];
      const Mat3 turn = packed_.scale[i] * packed_.orientation[i].toRotationMatrix();
      transform(b.mesh, turn, Vec3::Zero());
      b.radius = mesh_bounding_radius(b.mesh);
      b.outposts = outposts[packed_.shape[i]];
      for (Vec3& p : b.outposts) p = turn * p;
      b.wanted = volume[i];
      for (const Triangle& t : b.mesh.triangles)
        b.wedges.push_back(b.mesh.vertices[t[0]].dot(b.mesh.vertices[t[1]].cross(b.mesh.vertices[t[2]])));
    }
  });
}

// Keeps a plane at a distance from both centers. Centers too close for that share what there is.
double Growth::clamped(double offset, const Body& a, const Body& b, double apart) const {
  const double low = kInside * a.radius, high = apart - kInside * b.radius;
  return low < high ? std::clamp(offset, low, high) : apart * a.radius / (a.radius + b.radius);
}

// Between a body and its images one box edge away on both sides of each axis.
void Growth::separate_from_images(std::size_t i) {
  Body& body = bodies_[i];
  for (int axis = 0; axis < 3; ++axis) {
    const double edge = packed_.box[axis];
    if (2 * kReach * body.radius < edge) continue;
    double low = 0, high = 0;
    for (const Vec3& v : body.mesh.vertices) low = std::min(low, v[axis]), high = std::max(high, v[axis]);
    const double room = 0.5 * (edge - (high - low) - options_.gap);
    body.planes.push_back({Vec3::Unit(axis), high + room, -1});
    body.planes.push_back({-Vec3::Unit(axis), room - low, -1});
  }
}

void Growth::place_planes() {
  std::vector<double> reach;
  for (Body& b : bodies_) {
    b.reach = std::min(kReach * b.radius, 0.499 * packed_.box.minCoeff());
    reach.push_back(b.reach);
  }
  const auto pairs = packing::near_pairs(packed_.box, packed_.position, reach,
                                         (1 + options_.gap_variation) * options_.gap, work_.quiet());
  std::vector<Separation> separations(pairs.size());
  work_.part(0.1, 0.4).parallel(pairs.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Body &a = bodies_[pairs[k].a], &b = bodies_[pairs[k].b];
      const Vec3 between = packing::offset_of(pairs[k], packed_.box, packed_.position);
      Separation& s = separations[k] = widest_separation(a.outposts, b.outposts, between);
      s.end = extent_along(a.mesh, s.normal);
      s.start = s.normal.dot(between) - extent_along(b.mesh, -s.normal);
    }
  });
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Vec3 between = packing::offset_of(pairs[k], packed_.box, packed_.position);
    Separation s = separations[k];
    Body &a = bodies_[pairs[k].a], &b = bodies_[pairs[k].b];
    double apart = s.normal.dot(between);
    double gap = std::min(options_.gap, kWidest * std::min(a.radius, b.radius));
    if (options_.gap_variation > 0)
      gap *= 1 + options_.gap_variation * Random(options_.seed, kJointWidths, k).uniform(-1, 1);
    if (apart < 2 * kInside * (a.radius + b.radius) + gap) {  // the plane would miss a center
      s.normal = between.normalized(), apart = between.norm();
      s.end = s.start = apart * a.radius / (a.radius + b.radius);
      gap = std::min(gap, 0.5 * apart);
    }
    const double extent_a = s.end, extent_b = apart - s.start;
    contacts_.push_back({pairs[k].a, pairs[k].b, static_cast<int>(a.planes.size()),
                         static_cast<int>(b.planes.size()), apart, gap,
                         extent_a * extent_a - extent_b * extent_b});
    a.planes.push_back({s.normal, 0, pairs[k].b});
    b.planes.push_back({-s.normal, 0, pairs[k].a});
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) separate_from_images(i);
  if (options_.roundness > 0)
    for (Body& b : bodies_) b.set_power(3 / options_.roundness);
}

// A particle that had to grow more than others presses more.
void Growth::change_pressures(double step) {
  double mean = 0;
  for (const Body& b : bodies_) mean += b.growth / static_cast<double>(bodies_.size());
  for (Body& b : bodies_) b.pressure += step * std::clamp(b.growth / mean - 1, -0.3, 0.3);
}

// Sets the planes as those of a power diagram whose seeds have the extents of the bodies as radii and the
// pressures in their weights. Bodies that touch meet where they touch.
void Growth::move_planes() {
  for (const Contact& c : contacts_) {
    Body &a = bodies_[c.a], &b = bodies_[c.b];
    const double apart = c.apart - c.gap;  // of the two faces of the gap, as if it were not there
    const double offset = clamped(
        0.5 * (apart + (c.lead + (a.pressure - b.pressure) * a.radius * b.radius) / apart), a, b, apart);
    a.planes[c.plane_a].offset = offset;
    b.planes[c.plane_b].offset = apart - offset;
  }
}

Grown Growth::run() {
  Grown out;
  std::vector<double> reached(bodies_.size());
  for (int round = 0;; ++round) {
    move_planes();
    const Work part = work_.part(0.4 + 0.5 * round / (kRounds + 1), 0.4 + 0.5 * (round + 1) / (kRounds + 1));
    part.parallel(bodies_.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Body& body = bodies_[i];
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
    if (worst < kEnough || round == kRounds) break;
    change_pressures(kMove / (1 + 0.2 * round));
  }
  out.meshes.resize(bodies_.size());
  std::vector<Surface> surfaces(bodies_.size());
  work_.part(0.9, 1).parallel(bodies_.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      CutBody cut = cut_to_volume(bodies_[i], reached[i] == bodies_[i].wanted);
      surfaces[i] = surface_of(cut, near_a_plane(bodies_[i]));
      out.meshes[i] = std::move(cut.mesh);
    }
  });
  double all = 0;
  for (const Surface& s : surfaces) out.flat += s.flat, all += s.all;
  out.flat /= all;
  return out;
}

}  // namespace

Grown grow(const Shapes& shapes, const Particles& packed, const std::vector<double>& volume,
           const GrowOptions& options, const Work& work) {
  return Growth(shapes, packed, volume, options, work).run();
}

}  // namespace terrazzo::tessellation
