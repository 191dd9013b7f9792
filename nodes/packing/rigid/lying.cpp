#include "nodes/packing/rigid/lying.h"

#include <numbers>
#include <optional>

#include "nodes/common/geometry/mesh/shortest_axis.h"
#include "runtime/random.h"

namespace terrazzo::packing {
namespace {

constexpr std::uint64_t kLie = 0x6c6965;

}  // namespace

void lay_flat(Packing& packing, const Shapes& shapes, std::size_t first, std::uint64_t seed) {
  std::vector<std::optional<Quat>> flat;
  for (const Shape& s : shapes.shapes) flat.push_back(shortest_axis_up(s.mesh));
  for (std::size_t i = first; i < packing.count(); ++i) {
    const auto& turn = flat[packing.shape[i]];
    if (!turn) continue;
    Random random(seed, kLie, i);
    const double azimuth = random.uniform(0, 2 * std::numbers::pi);
    const Vec3 tilt(kTilt * random.normal(), kTilt * random.normal(), 0);
    const bool over = random.uniform() < 0.5;
    Quat q = Quat(Eigen::AngleAxisd(azimuth, Vec3::UnitZ())) * *turn;
    if (over) q = Quat(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX())) * q;
    if (tilt.norm() > 0) q = Quat(Eigen::AngleAxisd(tilt.norm(), tilt.normalized())) * q;
    packing.orientation[i] = q.normalized();
  }
}

}  // namespace terrazzo::packing
