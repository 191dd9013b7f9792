#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/components.h"
#include "nodes/common/geometry/disjoint_sets.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/indices.h"
#include "nodes/sizes/kmatrix/section_statistics.h"
#include "nodes/sizes/kmatrix/stencil_slicer.h"
#include "runtime/random.h"

namespace terrazzo::kmatrix {
namespace {

constexpr std::size_t kDefaultSlices = 16384;
// Smaller pieces, in pixels, next to larger ones are seams of clipped triangles.
constexpr std::int64_t kSpeck = 3;

struct Planned {
  SlicePlane plane;
  double width;  // of the body along the plane's normal, mm: the sampling weight of the plane
};

// The smallest rotation that turns u, which does not point away from the viewer, to the view axis. Eigen's
// own function also serves opposite directions, with a factorization that takes eight seconds to compile.
Quat to_view_axis(const Vec3& u) {
  const Vec3 from = u.normalized();
  const double s = std::sqrt((1 + from.z()) * 2);
  return Quat(s * 0.5, from.y() * (1 / s), -from.x() * (1 / s), 0);
}

// Directions and depths come from one quasi-random sequence in three dimensions (Roberts 2018). The rotation
// about the view axis is random, so that the pixels have no fixed alignment with the body.
Planned plan(const Mesh& mesh, std::size_t i) {
  const auto at = [i](double step, double start) { return std::fmod(start + step * (i + 1), 1.0); };
  const double z = std::abs(2 * at(0.8191725133961645, 0.5) - 1),
               phi = 2 * std::numbers::pi * at(0.6710436067037893, 0.5);
  const double r = std::sqrt(1 - z * z);
  const Vec3 u(r * std::cos(phi), r * std::sin(phi), z);
  double lo = u.dot(mesh.vertices[0]), hi = lo;
  for (const Vec3& v : mesh.vertices) {
    lo = std::min(lo, u.dot(v));
    hi = std::max(hi, u.dot(v));
  }
  const double turn = Random(1, 0, i).uniform(0, 2 * std::numbers::pi);
  const Quat rotation = Quat(Eigen::AngleAxisd(turn, Vec3::UnitZ())) * to_view_axis(u);
  return {{rotation, lo + (hi - lo) * at(0.5497004779019703, 0.5)}, hi - lo};
}

// Whether the surface is connected, so that every plane between the tangent planes meets it.
bool in_one_piece(const Mesh& mesh) {
  DisjointSets pieces(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    pieces.join(t[0], t[1]);
    pieces.join(t[0], t[2]);
  }
  const std::int32_t first = pieces.find(mesh.triangles[0][0]);
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [&](const Triangle& t) { return pieces.find(t[0]) == first; });
}

struct Body {
  bool convex, one_piece;
};

// Number of pixels of each disjoint profile in a tile.
std::vector<std::int64_t> profiles_of(const StencilSlicer& slicer, int slice, const Body& body) {
  const bool convex = body.convex;
  constexpr int kN = StencilSlicer::kTile;
  std::int64_t inside = 0;
  std::vector<std::int32_t> raster(convex ? 0 : static_cast<std::size_t>(kN) * kN);
  for (int y = 0; y < kN; ++y) {
    const std::uint32_t* row = slicer.row(slice, y);
    for (int w = 0; w < kN / 32; ++w) inside += std::popcount(row[w]);
    if (!convex)
      for (int x = 0; x < kN; ++x) raster[pixel_at(x, y, kN)] = row[x / 32] >> (x % 32) & 1;
  }
  if (inside == 0 && !body.one_piece) return {};
  if (convex || inside == 0) return {inside};  // the plane meets the body, possibly between pixels
  std::vector<std::int64_t> sizes = connected_components(raster, kN, kN, true).sizes;
  const std::int64_t most = *std::max_element(sizes.begin(), sizes.end());
  std::erase_if(sizes, [most](std::int64_t s) { return s < kSpeck && s < most; });
  return sizes;
}

using WidthHistogram = std::vector<double>;  // width in mm per bin of √(A/A_max)

}  // namespace

SectionStatistics stencil_statistics(const Shape& shape, int classes, std::size_t slices, GlDevice device,
                                     const Work& work) {
  const Body body{mesh_is_convex(shape.mesh), in_one_piece(shape.mesh)};
  const std::size_t count = slices > 0 ? slices : kDefaultSlices;
  StencilSlicer slicer(shape.mesh, device);
  WidthHistogram sum(kSectionBins, 0.0), half;
  double width = 0;
  for (std::size_t begin = 0; begin < count; begin += StencilSlicer::kSlices) {
    work.check();
    work.done(begin, count);
    const std::size_t n = std::min<std::size_t>(StencilSlicer::kSlices, count - begin);
    std::vector<SlicePlane> planes(n);
    std::vector<double> widths(n);
    work.quiet().parallel(n, 8, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        const Planned p = plan(shape.mesh, begin + i);
        planes[i] = p.plane;
        widths[i] = p.width;
      }
    });
    slicer.draw(planes);
    std::vector<std::vector<std::int64_t>> found(n);
    work.quiet().parallel(n, 8, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) found[i] = profiles_of(slicer, i, body);
    });
    for (std::size_t i = 0; i < n; ++i) {
      width += widths[i];
      for (const std::int64_t pixels : found[i]) {
        const double s = std::sqrt(pixels * slicer.pixel_area() / shape.max_section_area);
        const int bin = std::clamp(round_up(s * kSectionBins) - 1, 0, kSectionBins - 1);
        sum[bin] += widths[i];
      }
      if (begin + i + 1 == count / 2) half = sum;
    }
  }
  SectionStatistics s;
  s.orientations = count;
  s.residual = half.empty() ? 1 : largest_change(half, sum, classes);
  s.cdf.resize(kSectionBins);
  double total = 0;
  for (int b = 0; b < kSectionBins; ++b) s.cdf[b] = total += sum[b];
  for (double& f : s.cdf) f /= total;
  s.mean_caliper = shape.mean_caliper;
  s.max_section_area = shape.max_section_area;
  s.volume = shape.volume;
  s.profiles_per_caliper = body.convex ? 1 : total / width;
  return s;
}

}  // namespace terrazzo::kmatrix
