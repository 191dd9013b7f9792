#include "nodes/packing/rigid/shrunk_start.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/periodic.h"
#include "nodes/packing/rigid/spatial_order.h"

namespace terrazzo::packing {
namespace {

constexpr double kSame = 1e-9;        // relative difference of sizes from rounding
constexpr std::size_t kFirsts = 100;  // particles of the population that may be the first of the start

// The particles of `all` that `start` has, in order, if `first` is the first of them and gives the factor.
// Empty if there is one that `all` does not have.
std::vector<std::int32_t> members(const Particles& all, const Particles& start, std::size_t first) {
  const double factor = start.size[0] / all.size[first];
  if (!(factor > 0 && factor < 1 - kSame)) return {};
  std::vector<std::int32_t> found;
  std::size_t at = first;
  for (std::size_t i = 0; i < start.count(); ++i, ++at) {
    const auto same = [&] {
      return all.shape[at] == start.shape[i] && all.cls[at] == start.cls[i] &&
             std::abs(start.size[i] - factor * all.size[at]) <= kSame * start.size[i];
    };
    while (at < all.count() && all.count() - at >= start.count() - i && !same()) ++at;
    if (at >= all.count() || all.count() - at < start.count() - i) return {};
    found.push_back(at);
  }
  return found;
}

bool usable(const Particles& p, std::size_t i) {
  return p.position[i].allFinite() && std::abs(p.orientation[i].norm() - 1) < 1e-6;
}

}  // namespace

std::optional<Population> regrown(Population fresh, const Particles& start) {
  const std::size_t n = fresh.particles.count(), m = start.count();
  if (m == 0 || m > n || 2 * m < n) return {};
  if (!((start.box - fresh.particles.box).cwiseAbs().maxCoeff() <= kSame * fresh.particles.box.minCoeff()))
    return {};
  for (std::size_t i = 0; i < m; ++i)
    if (!usable(start, i)) return {};
  std::vector<std::int32_t> order;
  double factor = 1;
  for (std::size_t first = 0; order.empty() && first <= std::min(n - m, kFirsts); ++first) {
    order = members(fresh.particles, start, first);
    factor = start.size[0] / fresh.particles.size[first];
  }
  if (order.empty()) return {};
  std::vector<bool> known(n, false);
  for (const std::int32_t i : order) known[i] = true;
  for (std::size_t i = 0; i < n; ++i)
    if (!known[i]) order.push_back(i);
  Particles& p = fresh.particles;
  reorder(p.shape, order);
  reorder(p.cls, order);
  reorder(p.scale, order);
  reorder(p.size, order);
  reorder(p.color, order);
  reorder(p.voids, order);
  reorder(fresh.size_class, order);
  for (std::size_t i = 0; i < m; ++i) {
    p.position[i] = wrap_point(start.position[i], p.box);
    p.orientation[i] = start.orientation[i];
    if (!p.is_void(i)) p.color[i] = start.color[i];
  }
  fresh.kept = m;
  fresh.start_shrink = factor;
  return fresh;
}

}  // namespace terrazzo::packing
