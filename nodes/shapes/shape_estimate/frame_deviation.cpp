#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "nodes/common/geometry/mesh/mesh_section.h"
#include "nodes/shapes/shape_estimate/methods/morph_frame.h"

namespace terrazzo::shape_estimate {

namespace {

double distance_to(const Vec2& p, const std::vector<Loop>& loops) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec2 d = loop[(i + 1) % loop.size()] - loop[i];
      const double square = d.squaredNorm();
      const double t = square > 0 ? std::clamp((p - loop[i]).dot(d) / square, 0.0, 1.0) : 0;
      nearest = std::min(nearest, (p - loop[i] - t * d).squaredNorm());
    }
  return std::sqrt(nearest);
}

double diameter(const std::vector<Vec2>& curve) {
  double square = 0;
  for (const auto& p : curve)
    for (const auto& q : curve) square = std::max(square, (p - q).squaredNorm());
  return std::sqrt(square);
}

}  // namespace

std::vector<std::vector<Vec2>> frame_curves(const MorphFrame& frame) {
  std::vector<std::vector<Vec2>> curves(1);
  for (const auto& arc : frame.base)
    curves[0].insert(curves[0].end(), arc.points.begin(), arc.points.end() - 1);
  const std::size_t morphs = frame.radius.size() / 2;
  for (std::size_t k = 0; k < morphs; ++k) {
    std::vector<Vec2> curve;
    // Counter-clockwise from the right end of the base line; arcs start at their pole.
    const auto add = [&](const Arc& arc, double side, bool from_pole) {
      const std::size_t n = arc.points.size();
      for (std::size_t i = 0; i + 1 < n; ++i) {
        const Vec2& p = arc.points[from_pole ? i : n - 1 - i];
        curve.emplace_back(side * p.x(), p.y());
      }
    };
    add(frame.upper[k], 1, false);
    add(frame.upper[k + morphs], -1, true);
    add(frame.lower[k + morphs], -1, false);
    add(frame.lower[k], 1, true);
    curves.push_back(std::move(curve));
  }
  return curves;
}

double frame_deviation(const MorphFrame& frame, const Mesh& mesh) {
  const auto curves = frame_curves(frame);
  double worst = 0;
  for (std::size_t k = 0; k < curves.size(); ++k) {
    Mat3 plane = Mat3::Identity();
    if (k > 0) {
      const double angle = (k - 1) * std::numbers::pi / (curves.size() - 1);
      plane.col(0) = Vec3(std::cos(angle), std::sin(angle), 0);
      plane.col(1) = Vec3::UnitZ();
      plane.col(2) = plane.col(0).cross(plane.col(1));
    }
    const auto loops = section_loops(mesh, plane, 0);
    if (loops.empty()) return 1;
    const double size = diameter(curves[k]);
    for (const auto& p : curves[k]) worst = std::max(worst, distance_to(p, loops) / size);
  }
  return worst;
}

}  // namespace terrazzo::shape_estimate
