#include "nodes/packing/pack/fabric.h"

#include <cmath>

namespace terrazzo::pack {
namespace {

constexpr double kLong = 0.8;        // largest axis ratio
constexpr double kVisible = 0.85;    // of the whole silhouette
constexpr double kRayleigh = 6.908;  // ln 1000

struct Moments {
  double xx = 0, xy = 0, yy = 0;

  explicit Moments(const std::vector<Vec2>& contour) {
    Vec2 mean = Vec2::Zero();
    for (const Vec2& p : contour) mean += p / contour.size();
    for (const Vec2& p : contour) {
      const Vec2 d = p - mean;
      xx += d.x() * d.x();
      xy += d.x() * d.y();
      yy += d.y() * d.y();
    }
  }
  double direction() const { return std::atan2(2 * xy, xx - yy) / 2; }
  double axis_ratio() const {
    const double spread = std::hypot((xx - yy) / 2, xy);
    const double middle = (xx + yy) / 2;
    return middle > 0 ? std::sqrt(std::max(0.0, middle - spread) / (middle + spread)) : 1;
  }
};

}  // namespace

std::vector<double> long_axes(const Profiles& profiles) {
  std::vector<double> axes;
  Vec2 sum = Vec2::Zero();
  for (const Profile& p : profiles.profiles) {
    if (p.touches_border || p.contour.size() < 8 || p.area < kVisible * p.whole) continue;
    const Moments moments(p.contour);
    if (moments.axis_ratio() > kLong) continue;
    axes.push_back(moments.direction());
    sum += Vec2(std::cos(2 * axes.back()), std::sin(2 * axes.back()));
  }
  if (axes.empty() || sum.squaredNorm() / axes.size() < kRayleigh) return {};
  return axes;
}

}  // namespace terrazzo::pack
