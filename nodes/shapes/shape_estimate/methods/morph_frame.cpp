#include "nodes/shapes/shape_estimate/methods/morph_frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace terrazzo::shape_estimate {

namespace {

using std::numbers::pi;

// Extents of a morph profile from the intersection of its axis and its base line.
struct Reach {
  double right, top, left, bottom;
};

Reach reach_of(const std::vector<Arc>& quarters) {
  return {quarters[0].points.front().x(), quarters[1].points.front().y(), -quarters[2].points.front().x(),
          -quarters[3].points.front().y()};
}

const std::vector<double>& quarter_angles() {
  static const std::vector<double> angles{0, pi / 2, pi, 3 * pi / 2};
  return angles;
}

std::vector<Arc> quarters_of(const Outline& o) {
  return cut(o, cut_center(o, quarter_angles()), quarter_angles());
}

}  // namespace

MorphFrame morph_frame(std::vector<Outline> profiles, const std::string& axis, int base) {
  if (axis == "auto") {
    MorphFrame lying = morph_frame(profiles, "short", base), upright = morph_frame(profiles, "long", base);
    return upright.scaling < lying.scaling - 1e-9 ? upright : lying;
  }
  const std::size_t morphs = profiles.size() - 1, sectors = 2 * morphs;
  std::stable_sort(profiles.begin(), profiles.end(), [](const Outline& a, const Outline& b) {
    return std::abs(std::log(a.aspect)) < std::abs(std::log(b.aspect));
  });

  // The other profiles keep their order after the base.
  std::rotate(profiles.begin(), profiles.begin() + base, profiles.begin() + base + 1);

  MorphFrame frame;
  std::vector<double> angles;
  for (std::size_t j = 0; j < sectors; ++j) angles.push_back(j * pi / morphs);
  frame.base = cut(profiles[0], cut_center(profiles[0], angles), angles);
  for (const auto& arc : frame.base) frame.radius.push_back(arc.points.front().norm());

  // The longest chord gets the longest profile if profiles lie, the roundest if they stand upright: in both
  // cases the heights that they require are closest to each other.
  std::vector<std::size_t> chord(morphs);
  std::iota(chord.begin(), chord.end(), 0);
  std::stable_sort(chord.begin(), chord.end(), [&](auto a, auto b) {
    return frame.radius[a] + frame.radius[a + morphs] > frame.radius[b] + frame.radius[b + morphs];
  });
  std::vector<Outline> standing(morphs);
  for (std::size_t i = 0; i < morphs; ++i)
    standing[chord[i]] = axis == "long" ? profiles[1 + i].turned() : profiles[morphs - i];

  std::vector<std::vector<Arc>> quarters(morphs);
  double log_top = 0, log_bottom = 0;
  for (std::size_t k = 0; k < morphs; ++k) {
    Reach r = reach_of(quarters_of(standing[k]));
    const double wanted = std::log(frame.radius[k] / frame.radius[k + morphs]);
    if (std::log(r.right / r.left) * wanted < 0) standing[k] = standing[k].mirrored_x();
    if (r.top < r.bottom) standing[k] = standing[k].mirrored_y();
    quarters[k] = quarters_of(standing[k]);
    r = reach_of(quarters[k]);
    const double own = std::sqrt(frame.radius[k] * frame.radius[k + morphs] / (r.right * r.left));
    log_top += std::log(own * r.top) / morphs;
    log_bottom += std::log(own * r.bottom) / morphs;
  }
  const double top = std::exp(log_top), bottom = std::exp(log_bottom);

  frame.upper.resize(sectors);
  frame.lower.resize(sectors);
  for (std::size_t k = 0; k < morphs; ++k) {
    const Reach r = reach_of(quarters[k]);
    const double right = frame.radius[k] / r.right, left = frame.radius[k + morphs] / r.left;
    const double up = top / r.top, down = bottom / r.bottom;
    const auto [least, most] = std::minmax({right, left, up, down});
    frame.distortion = std::max(frame.distortion, most / least);
    for (const double scale : {right, left, up, down}) frame.scaling += std::log(scale) * std::log(scale);
    // Counter-clockwise from the right: right to top, top to left, left to bottom, bottom to right.
    auto& q = quarters[k];
    q[0].scale(right, up);
    q[0].reverse();
    q[1].scale(-left, up);
    q[2].scale(-left, down);
    q[2].reverse();
    q[3].scale(right, down);
    for (auto& arc : q) arc.parametrize();
    frame.upper[k] = q[0];
    frame.upper[k + morphs] = q[1];
    frame.lower[k] = q[3];
    frame.lower[k + morphs] = q[2];
  }
  return frame;
}

}  // namespace terrazzo::shape_estimate
