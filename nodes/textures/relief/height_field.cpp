#include "nodes/textures/relief/height_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/periodic.h"

namespace terrazzo::textures {
namespace {

// Half of the ball's width in texels at each row, and how far its top lies above its surface there.
struct BallRow {
  int dy = 0;
  std::vector<float> drop;  // mm, at −n … n texels
};

std::vector<BallRow> ball_rows(const HeightField& h, double radius) {
  std::vector<BallRow> rows;
  const int reach = round_down(radius / h.mm_y);
  for (int dy = -reach; dy <= reach; ++dy) {
    const double y = dy * h.mm_y;
    const int n = round_down(std::sqrt(std::max(0.0, radius * radius - y * y)) / h.mm_x);
    BallRow row{dy, {}};
    for (int dx = -n; dx <= n; ++dx) {
      const double square = radius * radius - y * y - dx * h.mm_x * dx * h.mm_x;
      row.drop.push_back(static_cast<float>(radius - std::sqrt(std::max(0.0, square))));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

// The lowest of the heights around each texel, raised by the ball's drop. With `sign` −1 the same for −mm.
std::vector<float> eroded(const HeightField& h, const std::vector<BallRow>& ball, float sign,
                          const Work& work) {
  std::vector<float> out(h.mm.size());
  work.quiet().parallel(h.height, 1, [&](std::size_t begin, std::size_t end) {
    std::vector<float> wide;
    for (std::size_t y = begin; y < end; ++y) {
      float* to = &out[y * h.width];
      std::fill(to, to + h.width, INFINITY);
      for (const BallRow& row : ball) {
        const int reach = count_of(row.drop) / 2;
        const float* from = &h.mm[pixel_at(0, wrap_index(static_cast<int>(y) + row.dy, h.height), h.width)];
        wide.resize(h.width + 2 * reach);
        for (int x = 0; x < count_of(wide); ++x) wide[x] = sign * from[wrap_index(x - reach, h.width)];
        for (int k = 0; k < count_of(row.drop); ++k)
          for (int x = 0; x < h.width; ++x) to[x] = std::min(to[x], wide[x + k] + row.drop[k]);
      }
    }
  });
  return out;
}

Vec3f normal_at(const HeightField& h, int x, int y) {
  const float right = h.at(wrap_index(x + 1, h.width), y), left = h.at(wrap_index(x - 1, h.width), y);
  const float up = h.at(x, wrap_index(y - 1, h.height)), down = h.at(x, wrap_index(y + 1, h.height));
  const Vec3f steep((left - right) / static_cast<float>(2 * h.mm_x),
                    (down - up) / static_cast<float>(2 * h.mm_y), 1);
  return steep.normalized();
}

// Offsets along a ray from a texel: each one, then at distances that grow by a tenth.
struct Step {
  int dx, dy;      // texels; dy downwards
  float distance;  // mm
};

std::vector<Step> ray_steps(const HeightField& h, double angle, double reach) {
  std::vector<Step> steps;
  const double texel = std::min(h.mm_x, h.mm_y);
  for (double d = texel; d <= reach; d = std::max(d + texel, d * 1.1)) {
    const int dx = round_nearest(d * std::cos(angle) / h.mm_x),
              dy = round_nearest(-d * std::sin(angle) / h.mm_y);
    const double distance = std::hypot(dx * h.mm_x, dy * h.mm_y);
    if (distance > 0 && (steps.empty() || dx != steps.back().dx || dy != steps.back().dy))
      steps.push_back({dx, dy, static_cast<float>(distance)});
  }
  return steps;
}

// The largest slope to any of these places, for each texel of a row.
void find_steepest(const HeightField& h, int y, const std::vector<Step>& steps, std::vector<float>& slope) {
  slope.assign(h.width, -INFINITY);
  const float* own = &h.mm[pixel_at(0, y, h.width)];
  for (const Step& s : steps) {
    const float* row = &h.mm[pixel_at(0, wrap_index(y + s.dy, h.height), h.width)];
    const int shift = wrap_index(s.dx, h.width), split = h.width - shift;
    const float scale = 1 / s.distance;
    for (int x = 0; x < split; ++x) slope[x] = std::max(slope[x], (row[x + shift] - own[x]) * scale);
    for (int x = split; x < h.width; ++x) slope[x] = std::max(slope[x], (row[x - split] - own[x]) * scale);
  }
}

// Light between the normal's projection into the slice and a horizon. Angles from the plane's normal.
float visible(float horizon, float normal) {
  return 0.25f * (-std::cos(2 * horizon - normal) + std::cos(normal) + 2 * horizon * std::sin(normal));
}

// `along`: direction of the slice. `ahead`, `behind`: slopes of the horizons.
float seen_in_slice(const Vec3f& n, const Eigen::Vector2f& along, float ahead, float behind) {
  if (n.z() == 1 && ahead <= 0 && behind <= 0) return 1;  // most of a worn plane
  constexpr float kRight = std::numbers::pi_v<float> / 2;
  const float across = n.head<2>().dot(along), normal = std::atan2(across, n.z());
  const float right = kRight - std::atan(ahead), left = std::atan(behind) - kRight;
  return std::hypot(across, n.z()) * (visible(normal + std::min(right - normal, kRight), normal) +
                                      visible(normal + std::max(left - normal, -kRight), normal));
}

}  // namespace

void round_edges(HeightField& h, double radius, const Work& work) {
  if (radius < std::min(h.mm_x, h.mm_y)) return;
  const std::vector<BallRow> ball = ball_rows(h, radius);
  h.mm = eroded(h, ball, 1, work);
  h.mm = eroded(h, ball, -1, work);
  for (float& mm : h.mm) mm = 0 - mm;  // not −0
}

Image normal_map(const HeightField& h, const Work& work) {
  Image out(h.width, h.height, 1, h.mm_x);
  work.quiet().parallel(h.height, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      for (int x = 0; x < h.width; ++x) {
        const int y = static_cast<int>(row);
        out.at(x, y) = 0.5f * (normal_at(h, x, y) + Vec3f::Ones());
      }
  });
  return out;
}

Image occlusion_map(const HeightField& h, const Work& work) {
  constexpr int kSlices = 8;
  constexpr double kFlat = 0.1;  // slopes of horizons that are not looked for, farther away than this allows
  Image out(h.width, h.height, 1, h.mm_x, Vec3f::Ones());
  const auto [low, high] = std::minmax_element(h.mm.begin(), h.mm.end());
  if (!(*high > *low)) return out;
  const double reach = std::min(double{*high - *low} / kFlat, std::max(h.width * h.mm_x, h.height * h.mm_y));
  struct Slice {
    Eigen::Vector2f along;
    std::vector<Step> ahead, behind;
  };
  std::vector<Slice> slices;
  for (int k = 0; k < kSlices; ++k) {
    const double angle = std::numbers::pi * (k + 0.5) / kSlices;
    slices.push_back({Eigen::Vector2d(std::cos(angle), std::sin(angle)).cast<float>(),
                      ray_steps(h, angle, reach), ray_steps(h, angle + std::numbers::pi, reach)});
  }
  work.parallel(h.height, 4, [&](std::size_t begin, std::size_t end) {
    std::vector<float> ahead, behind;
    std::vector<Vec3f> normals(h.width);
    for (std::size_t row = begin; row < end; ++row) {
      const int y = static_cast<int>(row);
      for (int x = 0; x < h.width; ++x) normals[x] = normal_at(h, x, y);
      std::vector<float> sum(h.width, 0.0f);
      for (const Slice& slice : slices) {
        find_steepest(h, y, slice.ahead, ahead);
        find_steepest(h, y, slice.behind, behind);
        for (int x = 0; x < h.width; ++x)
          sum[x] += seen_in_slice(normals[x], slice.along, ahead[x], behind[x]);
      }
      for (int x = 0; x < h.width; ++x) out.at(x, y).setConstant(std::clamp(sum[x] / kSlices, 0.0f, 1.0f));
    }
  });
  return out;
}

}  // namespace terrazzo::textures
