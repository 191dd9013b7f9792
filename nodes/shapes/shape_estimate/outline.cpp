#include "nodes/shapes/shape_estimate/outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/data/indices.h"

namespace terrazzo::shape_estimate {

namespace {

using std::numbers::pi;

double length(const std::vector<Vec2>& p) {
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += (p[(i + 1) % p.size()] - p[i]).norm();
  return sum;
}

double total_turn(const std::vector<Vec2>& p) {
  const std::size_t n = p.size();
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i)
    sum += std::abs(turn_between(p[i] - p[(i + n - 1) % n], p[(i + 1) % n] - p[i]));
  return sum;
}

std::vector<Vec2> without_repeats(const std::vector<Vec2>& contour) {
  Vec2 low = contour[0], high = contour[0];
  for (const auto& p : contour) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double least = 1e-9 * (high - low).norm();
  std::vector<Vec2> out;
  for (const auto& p : contour)
    if (out.empty() || (p - out.back()).norm() > least) out.push_back(p);
  while (out.size() > 1 && (out.back() - out.front()).norm() <= least) out.pop_back();
  return out;
}

// Positions along a closed polyline by arc length.
class ByLength {
 public:
  explicit ByLength(const std::vector<Vec2>& p) : p_(p), at_(p.size() + 1, 0) {
    for (std::size_t i = 0; i < p.size(); ++i) at_[i + 1] = at_[i] + (p[(i + 1) % p.size()] - p[i]).norm();
  }
  double total() const { return at_.back(); }
  double at(std::size_t i) const { return at_[i]; }
  Vec2 operator()(double s) const {
    s -= std::floor(s / total()) * total();
    std::size_t i = std::upper_bound(at_.begin(), at_.end(), s) - at_.begin();
    i = std::clamp<std::size_t>(i, 1, p_.size()) - 1;
    const double f = (s - at_[i]) / (at_[i + 1] - at_[i]);
    return (1 - f) * p_[i] + f * p_[(i + 1) % p_.size()];
  }

 private:
  const std::vector<Vec2>& p_;
  std::vector<double> at_;
};

std::vector<Vec2> resampled(const std::vector<Vec2>& p, std::size_t n) {
  const ByLength curve(p);
  std::vector<Vec2> out(n);
  for (std::size_t i = 0; i < n; ++i) out[i] = curve(curve.total() * static_cast<double>(i) / n);
  return out;
}

// Gaussian smoothing with standard deviation `sigma` (mm) of evenly spaced points, scaled
// to preserve the area.
std::vector<Vec2> smoothed(const std::vector<Vec2>& p, double sigma) {
  const double step = length(p) / p.size();
  const int n = p.size(), reach = std::min(n / 2, round_up(3 * sigma / step));
  std::vector<Vec2> out(p.size(), Vec2::Zero());
  for (int i = 0; i < n; ++i) {
    double weight = 0;
    for (int k = -reach; k <= reach; ++k) {
      const double w = std::exp(-0.5 * (k * step / sigma) * (k * step / sigma));
      out[i] += w * p[(i + k + n) % n];
      weight += w;
    }
    out[i] /= weight;
  }
  const double area = loop_area(out);
  if (!(area > 0)) return p;
  const double scale = std::sqrt(loop_area(p) / area);
  Vec2 middle = Vec2::Zero();
  for (const Vec2& q : out) middle += q / n;
  for (Vec2& q : out) q = middle + scale * (q - middle);
  return out;
}

// Inserts points so that no step is longer than `longest`; keeps all existing points.
std::vector<Vec2> densified(const std::vector<Vec2>& p, double longest) {
  std::vector<Vec2> out;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec2 d = p[(i + 1) % p.size()] - p[i];
    const int parts = std::max(1, round_up(d.norm() / longest));
    for (int k = 0; k < parts; ++k) out.push_back(p[i] + d * (static_cast<double>(k) / parts));
  }
  return out;
}

// Moves the centroid to the origin and aligns the long principal axis of the area's second moments with x.
void align(Outline& o) {
  std::vector<Vec2>& p = o.points;
  double area = 0;
  Vec2 first = Vec2::Zero();
  const Vec2 start = p[0];
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec2 a = p[i] - start, b = p[(i + 1) % p.size()] - start;
    const double c = cross(a, b) / 2;
    area += c;
    first += c * (a + b) / 3;
  }
  const Vec2 center = start + first / area;
  double xx = 0, yy = 0, xy = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec2 a = p[i] - center, b = p[(i + 1) % p.size()] - center;
    const double c = cross(a, b) / 12;
    xx += c * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
    yy += c * (a.y() * a.y() + a.y() * b.y() + b.y() * b.y());
    xy += c * (a.x() * a.y() + b.x() * b.y() + (a.x() * b.y() + b.x() * a.y()) / 2);
  }
  const bool round = std::abs(2 * xy) + std::abs(xx - yy) < 1e-9 * (xx + yy);
  const double angle = round ? 0 : 0.5 * std::atan2(2 * xy, xx - yy);
  const Eigen::Rotation2Dd turn(-angle);
  for (auto& q : p) q = turn * Vec2(q - center);
  o.center += Eigen::Rotation2Dd(o.turn) * center;
  o.turn += angle;
}

double normal_density(double u) { return std::exp(-0.5 * u * u) / std::sqrt(2 * pi); }
double normal_share(double u) { return 0.5 * std::erfc(-u / std::numbers::sqrt2); }

// The share of a corner's turn that is measured with arms of length u (in standard deviations) on either
// side, after Gaussian smoothing of the curve: the second difference of the smoothed ramp.
double seen_turn(double u) {
  return (u * (2 * normal_share(u) - 1) + 2 * normal_density(u) - 2 * normal_density(0)) / u;
}

// Turns are corrected to what they were before smoothing by `blur`.
void find_corners(Outline& o, double window, double blur, double crease) {
  const double near_share = blur > 0 ? seen_turn(window / blur) : 1,
               far_share = blur > 0 ? seen_turn(2 * window / blur) : 1;
  const std::size_t n = o.points.size();
  const ByLength curve(o.points);
  std::vector<double> strength(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const double s = curve.at(i);
    const auto over = [&](double w) {
      return turn_between(o.points[i] - curve(s - w), curve(s + w) - o.points[i]) * 180 / pi;
    };
    // Over twice the length, an arc turns twice as far and a bump turns back, but a corner turns no further.
    const double near = over(window) / near_share, far = over(2 * window) / far_share,
                 sign = near < 0 ? -1 : 1;
    strength[i] = sign * std::max(0.0, std::min({sign * near, sign * far, sign * (2 * near - far)}));
  }
  o.corner.assign(n, 0);
  o.corners = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (std::abs(strength[i]) < crease) continue;
    bool peak = true;
    for (const int side : {-1, 1})
      for (std::size_t k = 1; peak && k < n / 2; ++k) {
        const std::size_t j = (i + n + (side < 0 ? n - k : k)) % n;
        double away = std::abs(curve.at(j) - curve.at(i));
        away = std::min(away, curve.total() - away);
        if (away > window) break;
        const double a = std::abs(strength[j]), b = std::abs(strength[i]);
        peak = side < 0 ? a < b : a <= b;
      }
    if (!peak) continue;
    o.corner[i] = strength[i];
    ++o.corners;
  }
}

// Restores the tips of corners that smoothing removed: a corner of turn θ recedes by the distance between the
// ramp and the smoothed ramp, 2 sin(θ/2) σ (φ(u) − |u| Φ(−|u|)) at u standard deviations from it.
void restore_tips(Outline& o, double window, double blur) {
  const std::size_t n = o.points.size();
  const std::vector<Vec2> soft = o.points;
  const ByLength curve(soft);
  for (std::size_t i = 0; i < n; ++i) {
    if (o.corner[i] == 0) continue;
    const double s = curve.at(i);
    const Vec2 bend = (soft[i] - curve(s - window)).normalized() - (curve(s + window) - soft[i]).normalized();
    if (bend.norm() < 1e-6) continue;
    const double depth = 2 * std::sin(std::min(std::abs(o.corner[i]), 120.0) / 2 * pi / 180) * blur;
    for (std::size_t j = 0; j < n; ++j) {
      double away = std::abs(curve.at(j) - s);
      away = std::min(away, curve.total() - away) / blur;
      if (away < 4)
        o.points[j] += depth * (normal_density(away) - away * normal_share(-away)) * bend.normalized();
    }
  }
}

Outline mapped(const Outline& o, const Eigen::Matrix2d& m) {
  Outline out = o;
  for (auto& p : out.points) p = m * p;
  if (m.determinant() < 0) {
    std::reverse(out.points.begin(), out.points.end());
    std::reverse(out.corner.begin(), out.corner.end());
  }
  if (std::abs(m(0, 0)) < 0.5) {
    std::swap(out.width, out.height);
    out.aspect = 1 / out.aspect;
  }
  return out;
}

}  // namespace

Outline Outline::mirrored_x() const { return mapped(*this, Eigen::Vector2d(-1, 1).asDiagonal()); }
Outline Outline::mirrored_y() const { return mapped(*this, Eigen::Vector2d(1, -1).asDiagonal()); }
Outline Outline::turned() const { return mapped(*this, (Eigen::Matrix2d() << 0, -1, 1, 0).finished()); }

std::string outline_fault(const std::vector<Vec2>& contour) {
  if (contour.empty()) return "it has no contour";
  for (const auto& p : contour)
    if (!p.allFinite()) return "its contour has coordinates that are not finite";
  const auto p = without_repeats(contour);
  if (p.size() < 3) return fmt::format("its contour has only {} point{}", p.size(), p.size() == 1 ? "" : "s");
  const double area = loop_area(p), around = length(p);
  if (!(std::abs(area) > 1e-6 * around * around)) return "its contour encloses no area";
  // Sweep over x: only segments with overlapping intervals are tested.
  const std::size_t n = p.size();
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  const auto low = [&](std::size_t i) { return std::min(p[i].x(), p[(i + 1) % n].x()); };
  const auto high = [&](std::size_t i) { return std::max(p[i].x(), p[(i + 1) % n].x()); };
  std::sort(order.begin(), order.end(),
            [&](auto a, auto b) { return low(a) < low(b) || (low(a) == low(b) && a < b); });
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t l = k + 1; l < n && low(order[l]) <= high(order[k]); ++l) {
      const std::size_t i = std::min(order[k], order[l]), j = std::max(order[k], order[l]);
      if (j == i + 1 || (i == 0 && j == n - 1)) continue;
      const Vec2 &a = p[i], &b = p[(i + 1) % n], &c = p[j], &d = p[(j + 1) % n];
      const double ca = cross(d - c, a - c), cb = cross(d - c, b - c), ac = cross(b - a, c - a),
                   ad = cross(b - a, d - a);
      if (((ca > 0) != (cb > 0)) && ((ac > 0) != (ad > 0)))
        return fmt::format("its contour crosses itself near ({:.4g}, {:.4g})", a.x(), a.y());
    }
  return {};
}

Outline make_outline(int id, const std::vector<Vec2>& contour, double crease) {
  constexpr std::size_t kPoints = 256;
  Outline o;
  o.id = id;
  auto p = without_repeats(contour);
  if (loop_area(p) < 0) std::reverse(p.begin(), p.end());
  double blur = 0;
  if (p.size() >= 12) {
    std::vector<double> steps;
    for (std::size_t i = 0; i < p.size(); ++i) steps.push_back((p[(i + 1) % p.size()] - p[i]).norm());
    std::sort(steps.begin(), steps.end());
    const double sigma = kSmoothing * steps[steps.size() / 2];
    // Pixel steps have equal length; sections of meshes also have long steps.
    const bool even = steps[steps.size() - 1 - steps.size() / 50] < 2 * steps[steps.size() / 2];
    const std::size_t n = std::max(kPoints, 2 * p.size());
    const auto soft = smoothed(resampled(p, n), sigma);
    // Pixel steps turn back and forth; a curve that is sampled but not stepped turns no more
    // than its smoothed version.
    if (even && total_turn(p) > 1.25 * total_turn(soft) && outline_fault(soft).empty()) {
      o.traced = std::move(p);
      p = resampled(soft, kPoints);
      blur = sigma;
    }
  }
  o.blur = blur;
  const double area = blur > 0 ? loop_area(p) : 0;
  p = densified(p, length(p) / kPoints);
  o.points = std::move(p);
  align(o);
  if (blur > 0) o.soft = o.points;
  const double window = std::max(0.025 * length(o.points), 3.0 * blur);
  find_corners(o, window, blur, crease);
  if (blur > 0 && o.corners > 0) {
    Outline sharp = o;
    restore_tips(sharp, window, blur);
    const double scale = std::sqrt(area / loop_area(sharp.points));
    for (auto& q : sharp.points) q *= scale;
    align(sharp);
    if (outline_fault(sharp.points).empty()) o = std::move(sharp);
  }
  o.area = loop_area(o.points);
  o.perimeter = length(o.points);
  Vec2 low = o.points[0], high = low;
  for (const auto& q : o.points) {
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  o.width = high.x() - low.x();
  o.height = high.y() - low.y();
  o.circularity = 4 * pi * o.area / (o.perimeter * o.perimeter);
  o.aspect = o.height / o.width;
  o.convexity = std::min(1.0, o.area / hull_area(o.points));
  return o;
}

}  // namespace terrazzo::shape_estimate
