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
constexpr double kMostRows = 0x1p30;      // of texels, in all triangles

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

// Whether a triangle is lower in the texture than the steps to which its corners are rounded. If it has an
// area after rounding, or axes, these are chance.
bool is_flat(const CornerUv& uv, int size) {
  const Eigen::Vector2d a = size * (uv[1].cast<double>() - uv[0].cast<double>());
  const Eigen::Vector2d b = size * (uv[2].cast<double>() - uv[0].cast<double>());
  const double longest = std::max({a.norm(), b.norm(), (b - a).norm()});
  return !(std::abs(a.x() * b.y() - a.y() * b.x()) * static_cast<double>(kSubtexels) > longest);
}

// Checks for cancellation after every 65,536 texels or rows, however many a triangle has.
class Steps {
 public:
  explicit Steps(const Work& work) : work_(work) {}
  void add(std::int64_t steps) {
    since_ += steps;
    if (since_ < 65536) return;
    since_ = 0;
    work_.check();
  }

 private:
  const Work& work_;
  std::int64_t since_ = 0;
};

// Calls visit(row, first, last) for each row of texels whose centers lie inside. A center on an edge belongs
// to one of the two triangles beside it.
template <class Visit>
void scan(const Corners& c, Steps& steps, const Visit& visit) {
  constexpr std::int64_t kHalf = kSubtexels / 2;
  const auto [low, high] = std::minmax({c[0][1], c[1][1], c[2][1]});
  const std::int64_t last = floor_of(high - kHalf, kSubtexels);
  for (std::int64_t row = floor_of(low + kHalf - 1, kSubtexels); row <= last; ++row) {
    steps.add(1);
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
    if (from > to) continue;
    steps.add(to - from + 1);
    visit(row, from, to);
  }
}

Error bad_uv(const std::string& what) {
  return Error("bad-uv", what, "unwrap the mesh into 0 to 1, or set uv: atlas").parameter("uv");
}

// Also bounds the work that the triangles cause.
void check_coordinates(const std::vector<CornerUv>& uv, int size, const Work& work) {
  double layers = 0, rows = 0;
  for (std::size_t t = 0; t < uv.size(); ++t) {
    if (t % 65536 == 0) work.check();
    for (const Eigen::Vector2f& at : uv[t])
      if (!at.allFinite() || at.cwiseAbs().maxCoeff() > static_cast<float>(kFarthest))
        throw bad_uv(fmt::format("triangle {} has the texture coordinates ({:g}, {:g}), beyond ±{:g}", t,
                                 at.x(), at.y(), kFarthest));
    const Eigen::Vector2d a = (uv[t][1] - uv[t][0]).cast<double>(), b = (uv[t][2] - uv[t][0]).cast<double>();
    layers += std::abs(a.x() * b.y() - a.y() * b.x()) / 2;
    rows += size * std::max({std::abs(a.y()), std::abs(b.y()), std::abs(b.y() - a.y())});
  }
  if (layers > kFarthest) throw bad_uv(fmt::format("the triangles cover the texture {:.0f} times", layers));
  if (rows > kMostRows)
    throw bad_uv(
        fmt::format("the {} triangles have {:.3g} rows of texels, more than {:.3g}: they are slivers",
                    uv.size(), rows, kMostRows));
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

bool has_area(const Mesh& mesh, const Triangle& t) {
  const Vec3& a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm() > 0;
}

bool leaves_texture(const Corners& corners, int size) {
  const std::int64_t edge = size * kSubtexels;
  for (const Corner& corner : corners)
    for (const std::int64_t at : corner)
      if (at < 0 || at > edge) return true;
  return false;
}

}  // namespace

UvTexels find_texels(const Mesh& mesh, const std::vector<CornerUv>& uv, int size, int padding,
                     const Work& work) {
  check_coordinates(uv, size, work);
  UvTexels out;
  out.size = size;
  out.triangle.assign(pixels_in(size, size), -1);
  std::vector<bool> twice(out.triangle.size(), false);
  Steps steps(work);
  for (std::size_t t = 0; t < uv.size(); ++t) {
    if (t % 1024 == 0) {
      work.check();
      work.done(static_cast<double>(t), static_cast<double>(uv.size()));
    }
    const Corners corners = corners_of(uv[t], size);
    if (is_flat(uv[t], size) || doubled_area(corners) == 0 || !has_area(mesh, mesh.triangles[t])) {
      ++out.without_area;
      continue;
    }
    out.outside += leaves_texture(corners, size);
    scan(corners, steps, [&](std::int64_t row, std::int64_t from, std::int64_t to) {
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
                "raise resolution, or unwrap the mesh into 0 to 1")
        .parameter("resolution");
  pad(out, padding, work);
  return out;
}

void extend_to_blanks(const UvTexels& texels, std::vector<float>& values, const Work& work) {
  const int n = texels.size;
  std::vector<bool> known(values.size());
  for (std::size_t at = 0; at < known.size(); ++at) known[at] = texels.triangle[at] >= 0;
  std::vector<std::uint32_t> rim, next;
  const auto grow = [&](std::uint32_t at) {
    const int x = static_cast<int>(at % n), y = static_cast<int>(at / n);
    for (int k = 0; k < 9; ++k) {
      const std::size_t to = pixel_at(wrap_index(x + k % 3 - 1, n), wrap_index(y + k / 3 - 1, n), n);
      if (known[to]) continue;
      known[to] = true;
      values[to] = values[at];
      next.push_back(static_cast<std::uint32_t>(to));
    }
  };
  for (std::size_t at = 0; at < known.size(); ++at) {
    if (at % 65536 == 0) work.check();
    if (texels.triangle[at] >= 0) grow(static_cast<std::uint32_t>(at));
  }
  while (!next.empty()) {
    work.check();
    rim.swap(next);
    next.clear();
    for (const std::uint32_t at : rim) grow(at);
  }
}

TexelPlaces::TexelPlaces(const Mesh& mesh, const std::vector<CornerUv>& uv, int size, double scale,
                         const Work& work)
    : size_(size) {
  for (std::size_t t = 0; t < uv.size(); ++t) {
    if (t % 4096 == 0) work.check();
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
    Eigen::Matrix<double, 3, 2> axes = Eigen::Matrix<double, 3, 2>::Zero();
    if (!is_flat(uv[t], size)) axes = edges * flat.inverse();
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
