#include "nodes/common/stereology/random_sections.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "runtime/random.h"

namespace terrazzo {

namespace {

constexpr int kMostTries = 100000;

std::size_t pick(const std::vector<double>& cumulative, double u) {
  const auto at = std::upper_bound(cumulative.begin(), cumulative.end(), u * cumulative.back());
  return std::min<std::ptrdiff_t>(at - cumulative.begin(),
                                  static_cast<std::ptrdiff_t>(cumulative.size()) - 1);
}

}  // namespace

Mat3 frame_about(const Vec3& u) {
  // Duff et al. 2017: an orthonormal frame without a division by zero.
  const double sign = std::copysign(1.0, u.z()), a = -1 / (sign + u.z()), b = u.x() * u.y() * a;
  Mat3 m;
  m.col(0) = Vec3(1 + sign * u.x() * u.x() * a, sign * b, -sign * u.x());
  m.col(1) = Vec3(b, sign + u.y() * u.y() * a, -u.y());
  m.col(2) = u;
  return m;
}

std::vector<BodySection> random_sections(const Shapes& shapes, std::size_t count, const RandomSections& how,
                                         const Work& work) {
  if (shapes.shapes.empty()) throw Error("no-shapes", "there are no shapes to cut", "connect shapes");
  const bool central = how.kind == SectionKind::Central;
  std::vector<double> cumulative, radius;
  std::vector<Vec3> center;
  double sum = 0;
  for (const Shape& s : shapes.shapes) {
    sum += s.probability * (central ? 1 : s.mean_caliper);
    cumulative.push_back(sum);
    center.push_back(mesh_centroid(s.mesh));
    radius.push_back(mesh_bounding_radius(s.mesh, center.back()));
  }
  if (!(sum > 0) || !std::isfinite(sum))
    throw Error("bad-probabilities", "the shapes have no valid probabilities and mean caliper diameters");
  std::vector<BodySection> out(count);
  work.parallel(count, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      work.check();
      Random r(how.seed, central ? 811 : 812, how.first + i);
      const std::size_t k = pick(cumulative, r.uniform());
      // Draw planes until one intersects the body. Wide directions are then accepted more often, as required.
      for (int tries = 0; out[i].empty(); ++tries) {
        if (tries == kMostTries)
          throw Error("no-section", "no random plane intersects the shape '" + shapes.shapes[k].name + "'");
        const double z = r.uniform(-1, 1), phi = 2 * std::numbers::pi * r.uniform(), s = std::sqrt(1 - z * z);
        const Vec3 u(s * std::cos(phi), s * std::sin(phi), z);
        const double h = central ? 0 : radius[k] * r.uniform(-1, 1);
        out[i] = section_profiles(section_loops(shapes.shapes[k].mesh, frame_about(u), u.dot(center[k]) + h));
      }
    }
  });
  return out;
}

}  // namespace terrazzo
