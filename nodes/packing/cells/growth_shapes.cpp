#include "nodes/packing/cells/growth_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/directions.h"
#include "nodes/packing/cells/split_edges.h"
#include "nodes/packing/rigid/simplify.h"

namespace terrazzo::tessellation {
namespace {

constexpr double kLongestEdge = 0.2;  // of the finest meshes, in diameters of the shape
constexpr double kDeviation = 0.005;  // of a simplified shape, in its size
constexpr std::size_t kFewest = 500;  // triangles of a simplified shape
constexpr double kFiner = 1.25;       // factor by which their number rises until the deviation is kept
// Of detail. Each level has twice the deviation of the one before, and about half the triangles.
constexpr int kLevels = 4;

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
      if (h > highest) {
        highest = h;
        top = v;
      }
      if (h < lowest) {
        lowest = h;
        bottom = v;
      }
    }
    found.push_back(top);
    found.push_back(bottom);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<Vec3> points;
  for (std::size_t v : found) points.push_back(mesh.vertices[v]);
  return points;
}

GrowthShape simpler(const Shape& shape, const Mesh& from, int level, const Work& work) {
  GrowthShape to;
  // Deviations add up to kDeviation · 2^level.
  const double deviation = kDeviation * std::exp2(std::max(0, level - 1)) * shape.size();
  to.mesh = packing::simplified(from, deviation, work.quiet(), kFewest >> level, kFiner).mesh;
  const double longest = kLongestEdge * std::exp2(0.5 * level);
  split_long_edges(to.mesh, longest * std::cbrt(6 / std::numbers::pi * shape.volume));
  to.outposts = farthest_vertices(to.mesh);
  return to;
}

}  // namespace

const GrowthShape& GrowthShapes::at(const Shapes& shapes, std::int32_t shape, int level, const Work& work) {
  const auto [found, added] = prepared_.try_emplace({shape, level});
  if (added)
    found->second = simpler(shapes.shapes[shape], at(shapes, shape, level - 1, work).mesh, level, work);
  return found->second;
}

void GrowthShapes::make_finest(const Shapes& shapes, const Particles& p, const Work& work) {
  std::vector<std::pair<const Shape*, GrowthShape*>> missing;
  for (const std::int32_t s : p.shape)
    if (const auto [found, added] = prepared_.try_emplace({s, 0}); added)
      missing.emplace_back(&shapes.shapes[s], &found->second);
  work.parallel(missing.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      *missing[k].second = simpler(*missing[k].first, missing[k].first->mesh, 0, work);
  });
}

// Particles of the size `fine` or more have the finest level, smaller ones a level less per octave.
void GrowthShapes::assign(const Shapes& shapes, const Particles& p, double fine, const Work& work) {
  of_.clear();
  for (std::size_t i = 0; i < p.count(); ++i) {
    const double octaves = fine > p.size[i] ? std::ceil(std::log2(fine / p.size[i])) : 0;
    of_.push_back(&at(shapes, p.shape[i], std::min<int>(kLevels - 1, octaves), work));
  }
}

std::size_t GrowthShapes::triangles() const {
  std::size_t sum = 0;
  for (const GrowthShape* shape : of_) sum += shape->mesh.triangles.size();
  return sum;
}

void GrowthShapes::prepare(const Shapes& shapes, const Particles& p, const Work& work, double most) {
  if (p.count() == 0) return;
  make_finest(shapes, p, work);
  const double largest = *std::max_element(p.size.begin(), p.size.end());
  double fine = 0.5 * largest;
  assign(shapes, p, fine, work);
  while (static_cast<double>(triangles()) > most && fine < 16 * largest) {
    fine *= std::numbers::sqrt2;
    assign(shapes, p, fine, work);
  }
}

}  // namespace terrazzo::tessellation
