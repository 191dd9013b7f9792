#include "nodes/packing/rigid/lying.h"

#include <cmath>
#include <numbers>
#include <optional>

#include "nodes/common/geometry/mesh/shortest_axis.h"
#include "runtime/random.h"

namespace terrazzo::packing {
namespace {

constexpr std::uint64_t kLie = 0x6c6965;
// Radians by which traced shapes are turned from how their stones lay: little, since a photograph's stones
// often lie in one direction, and its light belongs to how they lay.
constexpr double kAside = 0.15;
constexpr double kTracedTilt = 0.1;

struct FlatBody {
  Quat turn;             // that lays the body down
  double long_axis = 0;  // its direction then, radians
};

std::optional<FlatBody> flat_body(const Mesh& mesh) {
  const auto turn = shortest_axis_up(mesh);
  if (!turn) return {};
  double xx = 0, xy = 0, yy = 0;
  for (const Vec3& v : mesh.vertices) {
    const Vec3 at = *turn * v;
    xx += at.x() * at.x();
    xy += at.x() * at.y();
    yy += at.y() * at.y();
  }
  return FlatBody{*turn, std::atan2(2 * xy, xx - yy) / 2};
}

}  // namespace

void lay_flat(Packing& packing, const Shapes& shapes, std::size_t first, const std::vector<double>& long_axes,
              std::uint64_t seed) {
  std::vector<std::optional<FlatBody>> flat;
  for (const Shape& s : shapes.shapes) flat.push_back(flat_body(s.mesh));
  for (std::size_t i = first; i < packing.count(); ++i) {
    const auto& body = flat[packing.shape[i]];
    const TracedStone& traced = shapes.shapes[packing.shape[i]].traced;
    if (!body && traced.profile == 0) continue;
    Random random(seed, kLie, i);
    double azimuth = random.uniform(0, 2 * std::numbers::pi);
    const double leaning = traced.profile != 0 ? kTracedTilt : kTilt;
    const Vec3 tilt(leaning * random.normal(), leaning * random.normal(), 0);
    const bool over = random.uniform() < 0.5;
    if (!long_axes.empty()) azimuth = long_axes[random.below(long_axes.size())];
    Quat q = Quat::Identity();
    if (traced.profile != 0) {
      azimuth = traced.turn + kAside * random.normal();
    } else {
      q = Quat(Eigen::AngleAxisd(-body->long_axis, Vec3::UnitZ())) * body->turn;
      if (over) q = Quat(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX())) * q;
    }
    q = Quat(Eigen::AngleAxisd(azimuth, Vec3::UnitZ())) * q;
    if (tilt.norm() > 0) q = Quat(Eigen::AngleAxisd(tilt.norm(), tilt.normalized())) * q;
    packing.orientation[i] = q.normalized();
  }
}

}  // namespace terrazzo::packing
