#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/profile_sweep.h"
#include "nodes/data/indices.h"
#include "nodes/sizes/kmatrix/grid_sweep.h"
#include "nodes/sizes/kmatrix/section_statistics.h"

namespace terrazzo::kmatrix {
namespace {

constexpr std::size_t kMostOrientations = 65536;
constexpr double kTolerance = 1e-3, kManyTolerance = 4e-3;
// From this number of triangles on, a convex body is smooth between the exact depths of GridSweep, and
// a direction is so expensive that the search stops at a change of 0.4 % (the remaining error is about
// a third of it).
constexpr std::size_t kManyTriangles = 1000;

// R2 sequence (Roberts 2018) on the half sphere: any prefix is evenly spread, so that directions can be
// added. `folded` folds it at the pole and the equator (baker's transformation), because a half sphere is not
// periodic across them. That is better by a factor of three for a thousand directions of a rounded body, and
// worse for many directions of a sharp one.
Vec3 direction(std::size_t i, bool folded) {
  const double k = i + 1;
  const double t = std::fmod(0.5 + 0.7548776662466927 * k, 1.0), x = folded ? std::abs(2 * t - 1) : t,
               y = std::fmod(0.5 + 0.5698402909980532 * k, 1.0);
  const double r = std::sqrt(1 - x * x), phi = 2 * std::numbers::pi * y;
  return {r * std::cos(phi), r * std::sin(phi), x};
}

// Depth in mm per bin of √(A/A_max), summed over directions.
struct Histogram {
  std::vector<double> depth = std::vector<double>(kSectionBins, 0.0);
  void operator+=(const Histogram& h) {
    for (int b = 0; b < kSectionBins; ++b) depth[b] += h.depth[b];
  }
};

// Adds the depths between t0 and t1 (fractions of a range), over which the area a + b·t + c·t² is monotonic.
void add_monotone(Histogram& out, double thickness, double t0, double t1, double a, double b, double c,
                  double max_area) {
  const double area0 = a + t0 * (b + t0 * c), area1 = a + t1 * (b + t1 * c);
  const bool rising = area1 >= area0;
  const auto bin = [&](double area) {
    const double s = std::sqrt(std::max(0.0, area) / max_area) * kSectionBins;
    return std::clamp(round_up(s) - 1, 0, kSectionBins - 1);
  };
  int k = bin(rising ? area0 : area1);
  const int last = bin(rising ? area1 : area0);
  if (k == last) {
    out.depth[k] += thickness * (t1 - t0);
    return;
  }
  // Where the area crosses a bin's upper edge: the root of the quadratic within [t0, t1], stable for small c.
  double t = rising ? t0 : t1;
  for (; k < last; ++k) {
    const double s = static_cast<double>(k + 1) / kSectionBins, d = a - s * s * max_area;
    const double root = std::sqrt(std::max(0.0, b * b - 4 * c * d));
    // The branch on which the derivative b + 2ct has the sign of the change: b + 2ct = ±root.
    const double slope = rising ? root : -root;
    const double q = -(b + (b >= 0 ? root : -root)) / 2;
    double next = (b >= 0) == (slope >= 0) ? (q != 0 ? d / q : t) : (c != 0 ? q / c : t);
    next = rising ? std::clamp(next, t, t1) : std::clamp(next, t0, t);
    out.depth[k] += thickness * std::abs(next - t);
    t = next;
  }
  out.depth[last] += thickness * std::abs((rising ? t1 : t0) - t);
}

void add(Histogram& out, const AreaRange& r, double max_area) {
  if (!(r.thickness > 0) || (r.low <= 0 && r.middle <= 0 && r.high <= 0)) return;
  const double a = r.low, b = 4 * r.middle - 3 * r.low - r.high, c = 2 * (r.low + r.high - 2 * r.middle);
  const double top = c != 0 ? -b / (2 * c) : -1;
  if (top > 0 && top < 1) {
    add_monotone(out, r.thickness, 0, top, a, b, c, max_area);
    add_monotone(out, r.thickness, top, 1, a, b, c, max_area);
  } else {
    add_monotone(out, r.thickness, 0, 1, a, b, c, max_area);
  }
}

std::vector<double> class_shares(const std::vector<double>& histogram, int classes) {
  std::vector<double> shares(classes, 0.0);
  double sum = 0;
  for (int b = 0; b < kSectionBins; ++b) {
    shares[static_cast<std::size_t>(b) * classes / kSectionBins] += histogram[b];
    sum += histogram[b];
  }
  for (double& s : shares) s /= sum;
  return shares;
}

}  // namespace

double largest_change(const std::vector<double>& before, const std::vector<double>& after, int classes) {
  const auto a = class_shares(before, classes), b = class_shares(after, classes);
  double largest = 0;
  for (int k = 0; k < classes; ++k)
    if (b[k] > 0) largest = std::max(largest, std::abs(b[k] - a[k]) / b[k]);
  return largest;
}

SectionStatistics slice_statistics(const Shape& shape, int classes, std::size_t orientations,
                                   const Work& work) {
  const bool convex = mesh_is_convex(shape.mesh),
             many = convex && shape.mesh.triangles.size() >= kManyTriangles;
  const auto run = [&](std::size_t first, std::size_t last, const Work& part) {
    return part.reduce(
        last - first, 32, Histogram{},
        [&](std::size_t begin, std::size_t end) {
          Histogram h;
          const auto sweep_all = [&](auto&& sweep, const auto& area_of) {
            for (std::size_t i = begin; i < end; ++i) {
              part.check();
              for (const auto& r : sweep.sweep(direction(first + i, many)))
                add(h, area_of(r), shape.max_section_area);
            }
          };
          const auto area = [](const AreaRange& r) -> const AreaRange& { return r; };
          if (!convex)
            sweep_all(ProfileSweep(shape.mesh),
                      [](const ProfileRange& r) -> const AreaRange& { return r.area; });
          else if (many)
            sweep_all(GridSweep(shape.mesh), area);
          else
            sweep_all(DepthSweep(shape.mesh), area);
          return h;
        },
        [](Histogram a, const Histogram& b) {
          a += b;
          return a;
        });
  };

  SectionStatistics s;
  const bool adaptive = orientations == 0;
  // Fewer triangles mean sharper peaks over the directions, and cheaper directions.
  const std::size_t first =
      many ? 512
           : std::clamp<std::size_t>(8192 * 500 / std::max<std::size_t>(1, shape.mesh.triangles.size()), 256,
                                     8192);
  std::size_t half = adaptive ? first : std::max<std::size_t>(1, orientations / 2);
  Histogram sum = run(0, half, work.part(0, adaptive ? 0.1 : 0.5));
  for (s.orientations = half;;) {
    const std::size_t all = adaptive ? 2 * half : std::max<std::size_t>(orientations, 2);
    const auto before = sum.depth;
    sum += run(half, all, adaptive ? work : work.part(0.5, 1));
    s.orientations = all;
    s.residual = largest_change(before, sum.depth, classes);
    if (!adaptive || s.residual <= (many ? kManyTolerance : kTolerance) || all >= kMostOrientations) break;
    half = all;
  }
  s.cdf.resize(kSectionBins);
  double depth = 0;
  for (int b = 0; b < kSectionBins; ++b) s.cdf[b] = depth += sum.depth[b];
  for (double& f : s.cdf) f /= depth;
  s.mean_caliper = shape.mean_caliper;
  s.max_section_area = shape.max_section_area;
  s.volume = shape.volume;
  s.profiles_per_caliper = convex ? 1 : depth / s.orientations / shape.mean_caliper;
  return s;
}

}  // namespace terrazzo::kmatrix
