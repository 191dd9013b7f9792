#include "nodes/textures/relief/height_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/periodic.h"

namespace terrazzo::textures {
namespace {

// The lowest of the parabolas heights[i] + curve · (x − i)² at each whole x, in time linear in their number
// (Felzenszwalb, Huttenlocher 2012, Distance transforms of sampled functions).
class LowerEnvelope {
 public:
  // Replaces the heights. `curve` > 0.
  void apply(std::vector<double>& heights, double curve) {
    lowest_.clear();
    from_.clear();
    for (int i = 0; i < count_of(heights); ++i) {
      double start = -INFINITY;
      while (!lowest_.empty()) {
        const int j = lowest_.back();
        start = 0.5 * (i + j) + (heights[i] - heights[j]) / (2 * curve * (i - j));
        if (start > from_.back()) break;
        lowest_.pop_back();
        from_.pop_back();
        start = -INFINITY;
      }
      lowest_.push_back(i);
      from_.push_back(start);
    }
    out_.resize(heights.size());
    std::size_t k = 0;
    for (int x = 0; x < count_of(heights); ++x) {
      while (k + 1 < from_.size() && from_[k + 1] < x) ++k;
      const double d = x - lowest_[k];
      out_[x] = heights[lowest_[k]] + curve * d * d;
    }
    heights.swap(out_);
  }

 private:
  std::vector<int> lowest_;   // parabolas of the envelope, from left to right
  std::vector<double> from_;  // where each of them begins
  std::vector<double> out_;
};

// Replaces `count` periodic heights, `stride` apart, by the lowest of their parabolas. Those farther away
// than `reach` are higher everywhere; nor can one matter that is farther away than its next image.
void lower_line(float* mm, int count, int stride, double curve, double reach, LowerEnvelope& envelope,
                std::vector<double>& line) {
  const int beyond = round_up(std::min(reach, count / 2.0 + 1));
  line.resize(count + 2 * beyond);
  for (int i = 0; i < count_of(line); ++i)
    line[i] = double{mm[static_cast<std::ptrdiff_t>(wrap_index(i - beyond, count)) * stride]};
  envelope.apply(line, curve);
  for (int i = 0; i < count; ++i)
    mm[static_cast<std::ptrdiff_t>(i) * stride] = static_cast<float>(line[beyond + i]);
}

// The highest surface that a paraboloid with this radius of curvature reaches with its apex while it stays
// below the heights. Its two dimensions are independent.
void erode(HeightField& h, double radius, double range, const Work& work) {
  const double reach = std::sqrt(2 * radius * range);
  work.part(0, 0.5).parallel(h.height, 16, [&](std::size_t begin, std::size_t end) {
    LowerEnvelope envelope;
    std::vector<double> line;
    for (std::size_t y = begin; y < end; ++y)
      lower_line(&h.mm[y * h.width], h.width, 1, h.mm_x * h.mm_x / (2 * radius), reach / h.mm_x, envelope,
                 line);
  });
  work.part(0.5, 1).parallel(h.width, 16, [&](std::size_t begin, std::size_t end) {
    LowerEnvelope envelope;
    std::vector<double> line;
    for (std::size_t x = begin; x < end; ++x)
      lower_line(&h.mm[x], h.height, h.width, h.mm_y * h.mm_y / (2 * radius), reach / h.mm_y, envelope, line);
  });
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

void round_edges(HeightField& h, double radius, double floor, const Work& work) {
  if (radius < std::min(h.mm_x, h.mm_y)) return;
  const std::vector<float> before = h.mm;
  const auto negate = [&] {
    for (float& mm : h.mm) mm = -mm;
  };
  for (float& mm : h.mm) mm = std::max(mm, static_cast<float>(floor));
  const auto [low, high] = std::minmax_element(h.mm.begin(), h.mm.end());
  const double range = double{*high} - double{*low};
  erode(h, radius, range, work.part(0, 0.5));
  negate();
  erode(h, radius, range, work.part(0.5, 1));
  negate();
  for (std::size_t i = 0; i < h.mm.size(); ++i) h.mm[i] = std::min(before[i], h.mm[i]);
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
