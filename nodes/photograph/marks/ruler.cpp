#include "nodes/photograph/marks/ruler.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::segment {
namespace {

float lightness(const Image& image, int x, int y, int section) {
  return linear_to_srgb(image.at(x, y, section).cwiseMax(0.0f).cwiseMin(1.0f)).sum() / 3;
}

float between(const Image& image, int section, double x, double y) {
  x = std::clamp(x, 0.0, image.width - 1.0);
  y = std::clamp(y, 0.0, image.height - 1.0);
  const int x0 = std::min<int>(x, std::max(0, image.width - 2)),
            y0 = std::min<int>(y, std::max(0, image.height - 2));
  const int x1 = std::min(x0 + 1, image.width - 1), y1 = std::min(y0 + 1, image.height - 1);
  const float u = x - x0, v = y - y0;
  return (1 - v) * ((1 - u) * lightness(image, x0, y0, section) + u * lightness(image, x1, y0, section)) +
         v * ((1 - u) * lightness(image, x0, y1, section) + u * lightness(image, x1, y1, section));
}

struct Period {
  double length = 0, uncertainty = 0, agreement = 0;  // samples; correlation
  int repeats = 0;
};

// Autocorrelation of a line without its slow changes.
std::vector<double> autocorrelation(const std::vector<float>& line) {
  const int n = line.size();
  std::vector<double> sums(n + 1, 0), value(n);
  for (int i = 0; i < n; ++i) sums[i + 1] = sums[i] + line[i];
  const int reach = std::max(4, n / 8);
  for (int i = 0; i < n; ++i) {
    const int a = std::max(0, i - reach), b = std::min(n, i + reach + 1);
    value[i] = line[i] - (sums[b] - sums[a]) / (b - a);
  }
  std::vector<double> out(n * 3 / 4, 0);
  for (int lag = 0; lag < count_of(out); ++lag) {
    double both = 0, first = 1e-9, second = 1e-9;
    for (int i = 0; i + lag < n; ++i) {
      both += value[i] * value[i + lag];
      first += value[i] * value[i];
      second += value[i + lag] * value[i + lag];
    }
    out[lag] = both / std::sqrt(first * second);
  }
  return out;
}

// Whether every quarter of the line varies; a word repeats its strokes too, but in one place.
bool all_along(const std::vector<float>& line) {
  double least = 1e30, sum = 0;
  for (int k = 0; k < 4; ++k) {
    const auto first = line.begin() + (line.size() * k / 4),
               last = line.begin() + (line.size() * (k + 1) / 4);
    const double n = last - first, mean = std::accumulate(first, last, 0.0) / n;
    double energy = 0;
    for (auto i = first; i < last; ++i) energy += (*i - mean) * (*i - mean) / n;
    least = std::min(least, energy);
    sum += energy / 4;
  }
  return least > 0.25 * sum;
}

Period shortest_period(const std::vector<float>& line) {
  const std::vector<double> a = autocorrelation(line);
  const int n = a.size();
  const auto summit_near = [&](double at, double slack) {
    int best = std::clamp(round_nearest(at), 1, n - 2);
    for (int i = std::max<int>(1, at - slack); i <= std::min(n - 2, static_cast<int>(at + slack) + 1); ++i)
      if (a[i] > a[best]) best = i;
    return best;
  };
  const auto refined = [&](int i) {
    const double bend = a[i - 1] - 2 * a[i] + a[i + 1];
    return bend < 0 ? i + 0.5 * (a[i - 1] - a[i + 1]) / bend : i;
  };
  if (!all_along(line)) return {};
  double highest = 0;
  bool fell = false;  // the slope of lag 0 is no summit
  for (int i = 1; i + 1 < n; ++i) {
    fell = fell || a[i] < 0.2;
    if (fell) highest = std::max(highest, a[i]);
  }
  if (highest < 0.45) return {};
  fell = false;
  for (int i = 1; i + 1 < n; ++i) {
    fell = fell || a[i] < 0.2;
    if (!fell || a[i] < 0.75 * highest || a[i] < a[i - 1] || a[i] < a[i + 1]) continue;
    Period p{refined(i), 0, a[i], 1};
    for (int k = 2; k * p.length + 1 < n; ++k) {
      const int next = summit_near(k * p.length, 0.25 * p.length);
      if (a[next] < 0.4 || std::abs(refined(next) - k * p.length) > 0.25 * p.length) break;
      p.length = refined(next) / k;
      p.repeats = k;
    }
    p.uncertainty = 0.5 / p.repeats;
    return p;
  }
  return {};
}

std::optional<ScaleMark> find_ticks(const Image& image, int section, const PixelBox& box,
                                    const IgnoredPixels& ignored) {
  Vec2 mean = Vec2::Zero();
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  double pixels = 0;
  for (int y = box.top; y <= box.bottom; ++y)
    for (int x = box.left; x <= box.right; ++x)
      if (ignored[image.index(x, y, section)]) {
        const Vec2 p(x, y);
        mean += p;
        square += p * p.transpose();
        ++pixels;
      }
  if (pixels < 100) return {};
  mean /= pixels;
  const auto axes = eigen_axes(Eigen::MatrixXd(square / pixels - mean * mean.transpose()));
  // A rectangle of half-length h has the variance h²/3 along it.
  const double half_width = std::sqrt(3 * std::max(0.0, axes.eigenvalues()[0])),
               half_length = std::sqrt(3 * axes.eigenvalues()[1]);
  if (half_length < 2.5 * half_width || half_length < 25) return {};
  const Vec2 along = axes.eigenvectors().col(1), across = axes.eigenvectors().col(0);
  constexpr double kStep = 0.5;  // pixels per sample
  std::optional<ScaleMark> best;
  for (int k = -4; k <= 4; ++k) {
    std::vector<float> line;
    for (double t = -0.96 * half_length; t <= 0.96 * half_length; t += kStep) {
      const Vec2 p = mean + t * along + (0.21 * k * half_width) * across;
      line.push_back(between(image, section, p.x(), p.y()));
    }
    const Period p = shortest_period(line);
    if (p.repeats < 5 || p.length * kStep < 2.5) continue;
    if (!best || p.length * kStep < best->length)
      best = ScaleMark{ScaleMark::Kind::Ticks, p.length * kStep, p.uncertainty * kStep};
  }
  return best;
}

std::optional<ScaleMark> find_bar(const Image& image, int section, const PixelBox& box) {
  constexpr float kSame = 0.12f, kApart = 0.25f;
  std::vector<float> all;
  for (int y = box.top; y <= box.bottom; ++y)
    for (int x = box.left; x <= box.right; ++x) all.push_back(lightness(image, x, y, section));
  const float usual = median(std::move(all));
  // Rows in line make a bar; a letter is not that long.
  int best = 0, from = -9, to = -9, rows = 0;
  const auto close = [&] {
    if (rows >= 2 && to - from >= 4 * rows) best = std::max(best, to - from);
  };
  for (int y = box.top; y <= box.bottom; ++y) {
    int left = -9, right = -9;
    for (int x = box.left; x <= box.right;) {
      const float first = lightness(image, x, y, section);
      int end = x;
      while (end <= box.right && std::abs(lightness(image, end, y, section) - first) < kSame) ++end;
      if (std::abs(first - usual) > kApart && end - x > right - left && x > box.left && end <= box.right) {
        left = x;
        right = end;
      }
      x = std::max(end, x + 1);
    }
    if (right > left && std::abs(left - from) <= 1 && std::abs(right - to) <= 1) {
      ++rows;
      from = std::max(from, left);
      to = std::min(to, right);
    } else {
      close();
      from = left;
      to = right;
      rows = right > left ? 1 : 0;
    }
  }
  close();
  constexpr int kShortest = 25;
  if (best < kShortest) return {};
  return ScaleMark{ScaleMark::Kind::Bar, static_cast<double>(best), 1};
}

}  // namespace

std::optional<ScaleMark> find_scale(const Image& image, int section, const PixelBox& box,
                                    const IgnoredPixels& ignored, ScaleMark::Kind first) {
  if (first == ScaleMark::Kind::Bar)
    if (const auto bar = find_bar(image, section, box)) return bar;
  if (const auto ticks = find_ticks(image, section, box, ignored)) return ticks;
  return find_bar(image, section, box);
}

}  // namespace terrazzo::segment
