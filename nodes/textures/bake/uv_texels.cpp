#include "nodes/textures/bake/uv_texels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/data/indices.h"

namespace terrazzo::bake {
namespace {

constexpr double kFarthest = 64;          // of texture coordinates, and the most layers over the texture
constexpr std::int64_t kSubtexels = 256;  // steps per texel to which corners are rounded

using Corner = std::array<std::int64_t, 2>;
using Corners = std::array<Corner, 3>;

std::int64_t floor_of(std::int64_t a, std::int64_t b) {
  return a / b - (a % b != 0 && (a % b < 0));
}  // b > 0

std::int64_t doubled_area(const Corners& c) {
  return (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[1][1] - c[0][1]) * (c[2][0] - c[0][0]);
}

// In either orientation, as triangles of mirrored halves have the other one.
Corners corners_of(const CornerUv& uv, int size) {
  Corners out;
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < 2; ++d)
      out[k][d] = std::llround(double{uv[k][d]} * size * static_cast<double>(kSubtexels));
  if (doubled_area(out) < 0) std::swap(out[1], out[2]);
  return out;
}

// Calls visit(row, first, last) for each row of texels whose centers lie inside. A center on an edge belongs
// to one of the two triangles beside it.
template <class Visit>
void scan(const Corners& c, const Work& work, const Visit& visit) {
  constexpr std::int64_t kHalf = kSubtexels / 2;
  const auto [low, high] = std::minmax({c[0][1], c[1][1], c[2][1]});
  const std::int64_t last = floor_of(high - kHalf, kSubtexels);
  for (std::int64_t row = floor_of(low + kHalf - 1, kSubtexels); row <= last; ++row) {
    if (row % 4096 == 0) work.check();
    std::int64_t from = INT64_MIN, to = INT64_MAX;
    for (int k = 0; k < 3; ++k) {
      const Corner &a = c[k], &b = c[(k + 1) % 3];
      const std::int64_t dx = b[0] - a[0], dy = b[1] - a[1];
      const bool owns = dy > 0 || (dy == 0 && dx > 0);
      // Inside where slope · x + rest ≥ 0 for whole x.
      const std::int64_t slope = -kSubtexels * dy;
      const std::int64_t rest = dx * (kSubtexels * row + kHalf - a[1]) - dy * (kHalf - a[0]) - !owns;
      if (slope > 0)
        from = std::max(from, -floor_of(rest, slope));
      else if (slope < 0)
        to = std::min(to, floor_of(rest, -slope));
      else if (rest < 0)
        to = INT64_MIN;
    }
    if (from <= to) visit(row, from, to);
  }
}

void check_coordinates(const std::vector<CornerUv>& uv) {
  double layers = 0;
  for (std::size_t t = 0; t < uv.size(); ++t) {
    for (const Eigen::Vector2f& at : uv[t])
      if (!(at.cwiseAbs().maxCoeff() <= static_cast<float>(kFarthest)))
        throw Error("bad-uv",
                    fmt::format("triangle {} has the texture coordinates ({:g}, {:g}), beyond ±{:g}", t,
                                at.x(), at.y(), kFarthest),
                    "unwrap the mesh into 0 to 1");
    const Eigen::Vector2d a = (uv[t][1] - uv[t][0]).cast<double>(), b = (uv[t][2] - uv[t][0]).cast<double>();
    layers += std::abs(a.x() * b.y() - a.y() * b.x()) / 2;
  }
  if (layers > kFarthest)
    throw Error("bad-uv", fmt::format("the triangles cover the texture {:.0f} times", layers),
                "unwrap the mesh into 0 to 1");
}

void pad(UvTexels& texels, int padding, const Work& work) {
  std::vector<std::uint32_t> rim, next;
  const int n = texels.size;
  const auto grow = [&](std::uint32_t at) {
    const int x = static_cast<int>(at % n), y = static_cast<int>(at / n);
    for (int k = 0; k < 9; ++k) {
      const int i = x + k % 3 - 1, j = y + k / 3 - 1;
      if (i < 0 || j < 0 || i >= n || j >= n) continue;
      std::int32_t& other = texels.triangle[pixel_at(i, j, n)];
      if (other >= 0) continue;
      other = texels.triangle[at];
      next.push_back(static_cast<std::uint32_t>(pixel_at(i, j, n)));
    }
  };
  if (padding == 0) return;
  const std::vector<std::int32_t> before = texels.triangle;
  for (std::size_t at = 0; at < before.size(); ++at) {
    if (at % 65536 == 0) work.check();
    if (before[at] >= 0) grow(static_cast<std::uint32_t>(at));
  }
  for (int step = 1; step < padding; ++step) {
    work.check();
    rim.swap(next);
    next.clear();
    for (const std::uint32_t at : rim) grow(at);
  }
}

}  // namespace

UvTexels find_texels(const Mesh& mesh, const std::vector<CornerUv>& uv, int size, int padding,
                     const Work& work) {
  check_coordinates(uv);
  UvTexels out;
  out.size = size;
  out.triangle.assign(pixels_in(size, size), -1);
  std::vector<bool> twice(out.triangle.size(), false);
  for (std::size_t t = 0; t < uv.size(); ++t) {
    if (t % 1024 == 0) work.check();
    const Corners corners = corners_of(uv[t], size);
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 area = (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    if (doubled_area(corners) == 0 || !(area.norm() > 0)) {
      ++out.without_area;
      continue;
    }
    const std::int64_t edge = size * kSubtexels;
    bool leaves = false;
    for (const Corner& corner : corners)
      for (const std::int64_t at : corner) leaves = leaves || at < 0 || at > edge;
    out.outside += leaves;
    scan(corners, work, [&](std::int64_t row, std::int64_t from, std::int64_t to) {
      const int y = wrap_index(static_cast<int>(row), size);
      for (std::int64_t column = from; column <= to; ++column) {
        const std::size_t at = pixel_at(wrap_index(static_cast<int>(column), size), y, size);
        if (out.triangle[at] >= 0) {
          out.overlapping += !twice[at];
          twice[at] = true;
          continue;
        }
        out.triangle[at] = static_cast<std::int32_t>(t);
        ++out.covered;
      }
    });
  }
  if (out.covered == 0)
    throw Error("bad-mesh", "no triangle of the mesh covers the center of a texel",
                "raise resolution, or unwrap the mesh into 0 to 1");
  pad(out, padding, work);
  return out;
}

TexelPlaces::TexelPlaces(const Mesh& mesh, const std::vector<CornerUv>& uv, int size, double scale)
    : size_(size) {
  for (std::size_t t = 0; t < uv.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 p = scale * mesh.vertices[a];
    Plane plane;
    for (int k = 0; k < 3; ++k) plane.q[k] = uv[t][k].cast<double>() * size;
    for (int d = 0; d < 2; ++d) {
      const auto [low, high] = std::minmax({plane.q[0][d], plane.q[1][d], plane.q[2][d]});
      plane.lo[d] = round_down(low / size);
      plane.hi[d] = std::max(plane.lo[d], round_up(high / size) - 1);
    }
    Eigen::Matrix2d flat;
    flat << plane.q[1] - plane.q[0], plane.q[2] - plane.q[0];
    Eigen::Matrix<double, 3, 2> edges;
    edges << scale * mesh.vertices[b] - p, scale * mesh.vertices[c] - p;
    const bool has_area = std::abs(flat.determinant()) > 0;
    const Eigen::Matrix<double, 3, 2> axes =
        has_area ? (edges * flat.inverse()).eval() : Eigen::Matrix<double, 3, 2>::Zero().eval();
    plane.right = axes.col(0);
    plane.down = axes.col(1);
    plane.origin = p - axes * plane.q[0];
    planes_.push_back(plane);
    normal_.push_back(Vec3(edges.col(0)).cross(Vec3(edges.col(1))).normalized());
  }
}

// Of a triangle that reaches several tiles, the one in which the texel lies deepest inside it.
Eigen::Vector2i TexelPlaces::tile(const Plane& plane, const Eigen::Vector2d& texel) const {
  if (plane.lo == plane.hi) return plane.lo;
  Eigen::Vector2i best = plane.lo;
  double deepest = -1e300;
  Eigen::Matrix2d flat;
  flat << plane.q[1] - plane.q[0], plane.q[2] - plane.q[0];
  const Eigen::Matrix2d inverse = flat.inverse();
  for (int j = plane.lo.y(); j <= plane.hi.y(); ++j)
    for (int i = plane.lo.x(); i <= plane.hi.x(); ++i) {
      const Eigen::Vector2d w = inverse * (texel + size_ * Eigen::Vector2d(i, j) - plane.q[0]);
      const double inside = std::min({w.x(), w.y(), 1 - w.x() - w.y()});
      if (inside <= deepest) continue;
      deepest = inside;
      best = {i, j};
    }
  return best;
}

Vec3 TexelPlaces::at(std::int32_t triangle, int x, int y, double right, double down) const {
  const Plane& plane = planes_[triangle];
  const Eigen::Vector2i t = tile(plane, {x + 0.5, y + 0.5});
  return plane.origin + (x + right + double(t.x()) * size_) * plane.right +
         (y + down + double(t.y()) * size_) * plane.down;
}

TexelPlaces::Axes TexelPlaces::axes(std::int32_t triangle) const {
  return {planes_[triangle].right, planes_[triangle].down, normal_[triangle]};
}

}  // namespace terrazzo::bake
