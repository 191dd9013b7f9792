#include "nodes/bodies/view/soil.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "graph/diagnostic.h"
#include "nodes/bodies/view/footprint.h"
#include "nodes/data/indices.h"

namespace terrazzo::view {
namespace {

using Meshes = std::vector<carving::RayScene::Triangles>;
using Stones = std::vector<carving::RayScene::Instance>;

constexpr double kMostCells = 4 << 20;  // finer than a screen shows
constexpr double kMostExtent = 1e15;    // mm, as for rays

// Radius in mm of the sphere around each stone's origin that holds it.
std::vector<double> radii_of(const Meshes& meshes, const Stones& stones) {
  std::vector<double> of_mesh;
  for (const carving::RayScene::Triangles& mesh : meshes) {
    double most = 0;
    for (const Vec3f& p : mesh.positions) most = std::max(most, p.cast<double>().norm());
    of_mesh.push_back(most);
  }
  std::vector<double> radii;
  for (const carving::RayScene::Instance& stone : stones)
    radii.push_back(of_mesh[stone.mesh] * stone.linear.col(0).cast<double>().norm());
  return radii;
}

CellGrid grid_for(const SoilOptions& options) {
  const Vec2& size = options.picture;
  if (!(size.maxCoeff() <= kMostExtent))
    throw Error("bad-number", "the picture exceeds 1e15 mm", "check width and height");
  CellGrid grid;
  grid.cell = std::max(
      {options.cell, std::sqrt(size.x() / kMostCells) * std::sqrt(size.y()), size.maxCoeff() / kMostCells});
  grid.width = std::max(1, round_nearest(size.x() / grid.cell));
  grid.height = std::max(1, round_nearest(size.y() / grid.cell));
  return grid;
}

// The cells around a stone's sphere.
Cells around(const carving::RayScene::Instance& stone, double radius, const CellGrid& grid) {
  const double reach = radius / grid.cell;
  Cells c;
  c.x = round_down(grid.column(stone.offset.x()) - reach);
  c.y = round_down(grid.row(stone.offset.y()) - reach);
  c.width = round_up(2 * reach) + 1;
  c.height = c.width;
  return c.within(grid);
}

}  // namespace

float reach_below(const carving::RayScene::Triangles& mesh, const Eigen::Matrix3f& linear) {
  const Vec3f up = linear.row(2);
  float lowest = -std::numeric_limits<float>::min();
  for (const Vec3f& p : mesh.positions) lowest = std::min(lowest, up.dot(p));
  return -lowest;
}

float exposure_of_share(const Meshes& meshes, const Stones& stones, const std::vector<float>& exposures,
                        const SoilOptions& options, double share, const Work& work) {
  const std::vector<double> radii = radii_of(meshes, stones);
  const CellGrid grid = grid_for(options);
  std::vector<std::pair<float, std::size_t>> order;
  for (std::size_t i = 0; i < stones.size(); ++i)
    if (stones[i].offset.z() + radii[i] > 0 && !around(stones[i], radii[i], grid).empty())
      order.emplace_back(exposures[i], i);
  std::sort(order.begin(), order.end());
  const auto wanted = std::llround(share * pixels_in(grid.width, grid.height));
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> covered =
      Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>::Constant(grid.width, grid.height, false);
  std::int64_t count = 0;  // of covered cells
  for (const auto& [exposure, i] : order) {
    work.check();
    const Cells near = around(stones[i], radii[i], grid);
    if (covered.block(near.x, near.y, near.width, near.height).all()) continue;
    const Footprint f = footprint_of(meshes[stones[i].mesh], stones[i], grid);
    const Cells c = f.cells.within(grid);
    for (int y = c.y; y < c.y + c.height; ++y)
      for (int x = c.x; x < c.x + c.width; ++x) {
        if (covered(x, y) || !(f.high(x - f.cells.x, y - f.cells.y) + stones[i].offset.z() > 0)) continue;
        covered(x, y) = true;
        ++count;
      }
    if (count > wanted) return exposure;
  }
  return order.empty() ? 0 : order.back().first;
}

}  // namespace terrazzo::view
