#include "nodes/bodies/view/footprint.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "nodes/data/indices.h"

namespace terrazzo::view {
namespace {

// Two triangles share each edge: the rounding of weights must not let a cell's center slip between them.
constexpr float kShared = 1e-4f;

// Corners in cells from the footprint's first one, and in mm above the stone's origin.
std::vector<Vec3f> corners_in(const carving::RayScene::Triangles& mesh,
                              const carving::RayScene::Instance& stone, const CellGrid& grid, Cells& cells) {
  const float scale = static_cast<float>(1 / grid.cell);
  std::vector<Vec3f> corners(mesh.positions.size());
  Eigen::AlignedBox3f box;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = stone.linear * mesh.positions[i];
    corners[i].head<2>() *= scale;
    box.extend(corners[i]);
  }
  const double x = grid.column(stone.offset.x());
  const double y = grid.row(stone.offset.y());
  cells.x = round_down(x + box.min().x());
  cells.y = round_down(y + box.min().y());
  const Vec3f shift(static_cast<float>(x - cells.x), static_cast<float>(y - cells.y), 0);
  for (Vec3f& corner : corners) corner += shift;
  cells.width = round_down(box.max().x() + shift.x()) + 1;
  cells.height = round_down(box.max().y() + shift.y()) + 1;
  return corners;
}

// Of numbers that aren't negative, in less time than std::floor takes: stones have many triangles.
int nearest(float v) { return static_cast<int>(v + 0.5f); }

// Adds a triangle to all cells whose centers it covers.
void cover(Footprint& f, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3f ab = b - a;
  const Vec3f ac = c - a;
  const float area = ab.x() * ac.y() - ab.y() * ac.x();
  if (area == 0) return;  // seen edge-on: its neighbors cover the same cells
  const Vec3f least = a.cwiseMin(b).cwiseMin(c);
  const Vec3f most = a.cwiseMax(b).cwiseMax(c);
  const int x0 = nearest(least.x());
  const int y0 = nearest(least.y());
  const int x1 = std::min(f.cells.width, nearest(most.x()));
  const int y1 = std::min(f.cells.height, nearest(most.y()));
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const float px = x + 0.5f - a.x();
      const float py = y + 0.5f - a.y();
      const float u = (px * ac.y() - py * ac.x()) / area;
      const float v = (ab.x() * py - ab.y() * px) / area;
      if (u < -kShared || v < -kShared || u + v > 1 + kShared) continue;
      const float z = a.z() + u * ab.z() + v * ac.z();
      f.high(x, y) = std::max(f.high(x, y), z);
    }
}

// The place of a corner in a footprint's map.
float& cell_of(CellMap& map, const Vec3f& corner) {
  const int x = std::clamp(round_down(corner.x()), 0, static_cast<int>(map.rows()) - 1);
  const int y = std::clamp(round_down(corner.y()), 0, static_cast<int>(map.cols()) - 1);
  return map(x, y);
}

}  // namespace

Cells Cells::within(const CellGrid& grid) const {
  Cells out;
  out.x = std::max(x, 0);
  out.y = std::max(y, 0);
  out.width = std::min(x + width, grid.width) - out.x;
  out.height = std::min(y + height, grid.height) - out.y;
  return out;
}

Footprint footprint_of(const carving::RayScene::Triangles& mesh, const carving::RayScene::Instance& stone,
                       const CellGrid& grid) {
  constexpr float kNowhere = std::numeric_limits<float>::infinity();
  Footprint f;
  const std::vector<Vec3f> corners = corners_in(mesh, stone, grid, f.cells);
  f.high = CellMap::Constant(f.cells.width, f.cells.height, -kNowhere);
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3)
    cover(f, corners[mesh.indices[t]], corners[mesh.indices[t + 1]], corners[mesh.indices[t + 2]]);
  const auto lower = [](const Vec3f& a, const Vec3f& b) { return a.z() < b.z(); };
  const Vec3f& highest = *std::max_element(corners.begin(), corners.end(), lower);
  cell_of(f.high, highest) = highest.z();
  return f;
}

}  // namespace terrazzo::view
