#include "nodes/packing/cells/growing_body.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/packing/cells/split_edges.h"

namespace terrazzo::tessellation {
namespace {

constexpr double kLargest = 4;  // largest factor of growth
constexpr int kHalvings = 16;
constexpr double kExact = 1e-3;    // relative error of a volume that needs no correction
constexpr double kNoEdge = 0.003;  // share of the norm that is left out
// Effort of a plane's share in a norm, of a vertex of a mesh that is split, of a vertex that is limited, and
// of a triangle's share in a volume.
constexpr std::size_t kPowers = 8, kSplit = 60, kLimit = 20, kVolume = 4;

// How far a point is towards the planes, as a norm that is 1 on the body's planes except near their edges,
// where it is larger, and so rounds them. Results below `least` may be smaller than they are.
// `shares` is working memory.
double gauge(const GrowingBody& body, const Vec3& v, double least, std::vector<double>& shares) {
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

double volume_at(const GrowingBody& body, const std::vector<double>& limit, double growth) {
  double six = 0;
  for (std::size_t k = 0; k < body.wedges.size(); ++k) {
    const Triangle& t = body.mesh.triangles[k];
    six += body.wedges[k] * std::min(growth, limit[t[0]]) * std::min(growth, limit[t[1]]) *
           std::min(growth, limit[t[2]]);
  }
  return six / 6;
}

double near_a_plane(const GrowingBody& body) { return 1e-9 * body.radius; }

// Cuts the enlarged body at its planes. What lies beyond a plane moves onto it along rays from the center.
// Then rounds the edges.
CutBody cut(GrowingBody& body) {
  CutBody out;
  Mesh& mesh = out.mesh = body.mesh;
  for (Vec3& v : mesh.vertices) v *= body.growth;
  const double near = near_a_plane(body);
  double farthest = body.growth * body.radius;  // of what the planes have left so far
  for (const Plane& p : body.nearest) {
    if (p.offset > farthest) break;
    double top = -1e300, longest = 0;
    for (const Vec3& v : mesh.vertices) {
      top = std::max(top, p.normal.dot(v));
      longest = std::max(longest, v.squaredNorm());
    }
    farthest = std::sqrt(longest) + near;
    body.work += static_cast<double>(mesh.vertices.size());
    if (top <= p.offset + near) continue;
    body.work += static_cast<double>(kSplit * mesh.vertices.size());
    out.planes.push_back(p);
    split_at_plane(mesh, p.normal, p.offset, near);
    for (Vec3& v : mesh.vertices)
      if (const double h = p.normal.dot(v); h > p.offset) v *= p.offset / h;
  }
  out.sharp = mesh.vertices;
  std::vector<double> shares;
  if (body.power > 0)
    for (Vec3& v : mesh.vertices)
      if (const double far = gauge(body, v, 1, shares); far > 1) {
        v /= far;
        body.work += static_cast<double>(kPowers * shares.size());
      }
  return out;
}

}  // namespace

void GrowingBody::set_power(double value) {
  power = value;
  alone = power > 0 ? std::pow(static_cast<double>(std::max<std::size_t>(planes.size(), 1)), -1 / power) : 1;
  no_edge = power > 0 ? std::pow(kNoEdge, 1 / power) : 1;
}

void GrowingBody::sort_planes() {
  nearest = planes;
  std::stable_sort(nearest.begin(), nearest.end(),
                   [](const Plane& a, const Plane& b) { return a.offset < b.offset; });
}

std::vector<double> limits_of(GrowingBody& body) {
  std::vector<double> limit;
  body.work += static_cast<double>(kLimit * body.mesh.vertices.size());
  for (const Vec3& v : body.mesh.vertices) limit.push_back(std::min(kLargest, body.reach / v.norm()));
  if (body.power > 0) {
    std::vector<double> shares;
    for (std::size_t v = 0; v < limit.size(); ++v) {
      limit[v] = std::min(limit[v], 1 / gauge(body, body.mesh.vertices[v], 1 / limit[v], shares));
      body.work += static_cast<double>(kPowers * shares.size());
    }
    return limit;
  }
  for (std::size_t k = 0; k < limit.size(); ++k) {
    const Vec3& v = body.mesh.vertices[k];
    const double length = (1 + 1e-9) * v.norm();
    for (const Plane& p : body.nearest) {
      ++body.work;
      if (p.offset > body.reach || p.offset > length * limit[k]) break;  // all others are farther
      const double h = p.normal.dot(v);
      if (h * limit[k] > p.offset) limit[k] = p.offset / h;
    }
  }
  return limit;
}

double solve_growth(GrowingBody& body, const std::vector<double>& limits) {
  double low = 0, high = kLargest, at_low = 0;
  double at_high = std::cbrt(volume_at(body, limits, high));
  const double goal = std::cbrt(body.wanted);
  if (at_high <= goal) {
    body.growth = high;
    return std::pow(at_high, 3);
  }
  double at = body.growth < high ? body.growth : 0.5 * high;  // that of the last round is close
  for (int k = 0; k < 40; ++k) {
    const double reached = std::cbrt(volume_at(body, limits, at));
    body.work += static_cast<double>(kVolume * body.wedges.size());
    if (std::abs(reached - goal) < 1e-6 * goal) break;
    (reached > goal ? high : low) = at;
    (reached > goal ? at_high : at_low) = reached;
    // The cube root of the volume is nearly linear in the factor, except where planes stop the growth.
    const double share = std::clamp((goal - at_low) / (at_high - at_low), 0.1, 0.9);
    at = low + share * (high - low);
  }
  body.growth = at;
  return body.wanted;
}

// Cutting keeps what triangles across an edge leave out of the volume at the vertices.
CutBody cut_to_volume(GrowingBody& body, bool reached, int repeats) {
  CutBody out = cut(body);
  const double wanted = body.wanted;
  double volume = mesh_volume(out.mesh);
  if (!reached && volume <= wanted) return out;
  const auto limits = limits_of(body);
  double low = 0, high = 0;  // factors of growth with too little and too much volume
  double at_low = 0, at_high = 0;
  const auto note = [&] {
    if (volume > wanted) {
      high = body.growth;
      at_high = std::cbrt(volume);
    } else {
      low = body.growth;
      at_low = std::cbrt(volume);
    }
  };
  note();
  for (int k = 0; k < repeats && std::abs(wanted / volume - 1) >= kExact; ++k) {
    body.wanted *= wanted / volume;
    solve_growth(body, limits);
    out = cut(body);
    volume = mesh_volume(out.mesh);
    note();
  }
  // Where a plane is close to the center, the vertices say too little about the volume.
  for (int k = 0; k < kHalvings * (repeats > 0) && high > low && volume > 1.02 * wanted; ++k) {
    const double share = std::clamp((std::cbrt(wanted) - at_low) / (at_high - at_low), 0.1, 0.9);
    body.growth = low + share * (high - low);
    out = cut(body);
    volume = mesh_volume(out.mesh);
    note();
  }
  return out;
}

GrownSurface surface_of(const CutBody& cut, const GrowingBody& body) {
  const double near = near_a_plane(body);
  GrownSurface surface;
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

}  // namespace terrazzo::tessellation
