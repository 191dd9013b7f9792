#include "nodes/textures/bake/box_atlas.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"

namespace terrazzo::bake {
namespace {

constexpr std::size_t kCheckEvery = 4096;  // triangles

// The side of a box that a triangle faces: axis · 2, plus 1 if it is the negative one.
int side_of(const Mesh& mesh, const Triangle& t) {
  const Vec3& a = mesh.vertices[t[0]];
  const Vec3 n = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(n[k]) > std::abs(n[axis])) axis = k;
  return 2 * axis + (n[axis] < 0);
}

// To the right and downwards as seen from outside, so that no chart is mirrored.
Eigen::Vector2d projected(const Vec3& p, int side) {
  const int axis = side / 2;
  const double right = p[(axis + 1) % 3], up = p[(axis + 2) % 3];
  return {side % 2 ? -right : right, -up};
}

struct Chart {
  int side = 0;
  std::vector<std::size_t> triangles;
  Eigen::AlignedBox2d box;                           // mm
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  // its place in the texture, texels
};

// The triangles at each edge that face the same side, by the edge's vertices and the side.
using EdgeTriangles = std::map<std::array<int, 3>, std::vector<std::size_t>>;

std::array<int, 3> edge_of(const Triangle& t, int k, int side) {
  const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
  return {low, high, side};
}

// Of the triangle `start`, and all that it is connected to. Empties the lists of the edges that it visits:
// their triangles are taken, and lists visited once for each of their triangles would take quadratic time.
Chart grow_chart(const Mesh& mesh, std::size_t start, int side, EdgeTriangles& edges,
                 std::vector<bool>& taken, const Work& work) {
  Chart chart;
  chart.side = side;
  chart.triangles = {start};
  taken[start] = true;
  for (std::size_t i = 0; i < chart.triangles.size(); ++i) {
    if (i % kCheckEvery == 0) work.check();
    const Triangle& t = mesh.triangles[chart.triangles[i]];
    for (int k = 0; k < 3; ++k) {
      chart.box.extend(projected(mesh.vertices[t[k]], side));
      std::vector<std::size_t>& beside = edges.at(edge_of(t, k, side));
      for (const std::size_t other : beside)
        if (!taken[other]) {
          taken[other] = true;
          chart.triangles.push_back(other);
        }
      beside.clear();
    }
  }
  return chart;
}

std::vector<Chart> charts_of(const Mesh& mesh, const Work& work) {
  EdgeTriangles edges;
  std::vector<int> side;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % kCheckEvery == 0) work.check();
    side.push_back(side_of(mesh, mesh.triangles[t]));
    for (int k = 0; k < 3; ++k) edges[edge_of(mesh.triangles[t], k, side[t])].push_back(t);
  }
  std::vector<Chart> out;
  std::vector<bool> taken(mesh.triangles.size(), false);
  for (std::size_t start = 0; start < taken.size(); ++start) {
    if (start % kCheckEvery == 0) work.check();
    if (!taken[start]) out.push_back(grow_chart(mesh, start, side[start], edges, taken, work));
  }
  return out;
}

// Places the charts in rows, the highest first. False if they do not fit.
bool pack(std::vector<Chart>& charts, const std::vector<std::size_t>& order, double scale, int size,
          int gap) {
  double x = gap, y = gap, row = 0;
  for (const std::size_t c : order) {
    const Eigen::Vector2d extent = charts[c].box.sizes() * scale;
    const double width = std::ceil(extent.x()) + gap, height = std::ceil(extent.y()) + gap;
    if (x + width > size) {
      x = gap;
      y += row;
      row = 0;
    }
    if (x + width > size || y + height > size) return false;
    charts[c].corner = {x, y};
    x += width;
    row = std::max(row, height);
  }
  return true;
}

}  // namespace

BoxAtlas box_atlas(const Mesh& mesh, int size, int gap, const Work& work) {
  std::vector<Chart> charts = charts_of(mesh, work);
  std::vector<std::size_t> order(charts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return charts[a].box.sizes().y() > charts[b].box.sizes().y();
  });
  double longest = 0;
  for (const Chart& c : charts) longest = std::max(longest, c.box.sizes().maxCoeff());
  const auto largest_scale = [&](int between) {
    double low = 0, high = longest > 0 ? size / longest : 1;
    for (int step = 0; step < 40; ++step) {
      work.check();
      const double middle = (low + high) / 2;
      (pack(charts, order, middle, size, between) ? low : high) = middle;
    }
    return low;
  };
  const double most = largest_scale(1);
  if (most == 0)
    throw Error(
        "too-many-charts",
        fmt::format("the {} charts of the mesh do not fit into {} × {} texels", charts.size(), size, size),
        "raise resolution, or unwrap the mesh in a mesh editor")
        .parameter("resolution");
  constexpr double kLeast = 0.7;  // of the largest scale: gaps take at most about half of the texture
  double scale = largest_scale(gap);
  while (gap > 1 && scale < kLeast * most) scale = largest_scale(gap /= 2);
  pack(charts, order, scale, size, gap);
  BoxAtlas out{std::vector<CornerUv>(mesh.triangles.size()), gap};
  work.check();
  for (const Chart& chart : charts)
    for (const std::size_t t : chart.triangles)
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector2d mm = projected(mesh.vertices[mesh.triangles[t][k]], chart.side);
        out.uv[t][k] = ((chart.corner + scale * (mm - chart.box.min())) / size).cast<float>();
      }
  return out;
}

}  // namespace terrazzo::bake
