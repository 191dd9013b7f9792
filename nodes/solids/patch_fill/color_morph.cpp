#include "nodes/solids/patch_fill/color_morph.h"

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/texture/color.h"

namespace terrazzo::patch_fill {
namespace {

// The rank of a value, 0 to 1. The middle of the ranks if the table has the value several times.
double rank_of(const std::vector<float>& table, float value) {
  const auto [low, high] = std::equal_range(table.begin(), table.end(), value);
  const double last = table.size() - 1;
  if (low != high)
    return 0.5 * (static_cast<double>(low - table.begin()) + (high - table.begin() - 1)) / last;
  if (low == table.begin()) return 0;
  if (low == table.end()) return 1;
  const float before = *(low - 1), after = *low;
  return (static_cast<double>(low - table.begin()) - 1 + (value - before) / (after - before)) / last;
}

}  // namespace

ColorMorph::Solid ColorMorph::measure(const std::vector<Vec3f>& colors, const char* name) {
  Solid out;
  std::vector<Vec3f> lab(colors.size());
  Vec3 mean = Vec3::Zero();
  Mat3 square = Mat3::Zero();
  for (std::size_t i = 0; i < colors.size(); ++i) {
    lab[i] = linear_to_oklab(colors[i]);
    const Vec3 c = lab[i].cast<double>();
    mean += c;
    square += c * c.transpose();
  }
  const double n = colors.size();
  mean /= n;
  const Mat3 covariance = square / n - mean * mean.transpose();
  out.deviation = std::sqrt(std::max(0.0, covariance.trace()));
  if (!(out.deviation > 1e-4))
    throw Error("one-color", std::string("solid ") + name + " has a single color",
                "connect a solid with visible texture");
  out.mean = mean.cast<float>();
  out.axes = principal_axes(eigen_axes(covariance));
  return out;
}

ColorMorph::ColorMorph(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b)
    : solid_{measure(a, "a"), measure(b, "b")} {
  // The sign of an axis is arbitrary. Light must correspond to light, and otherwise like hues to each other.
  const Vec3 importance(4, 1, 1);
  for (int k = 0; k < 3; ++k)
    if (solid_[0].axes.col(k).cwiseProduct(importance).dot(solid_[1].axes.col(k)) < 0)
      solid_[1].axes.col(k) *= -1;
  for (std::size_t s = 0; s < 2; ++s)
    for (int k = 0; k < 3; ++k) {
      const Vec3f axis = solid_[s].axes.col(k).cast<float>();
      std::vector<float> values;
      for (const Vec3f& c : s == 0 ? a : b) values.push_back(axis.dot(linear_to_oklab(c) - solid_[s].mean));
      solid_[s].values[k] = quantiles_of(values);
    }
  for (std::size_t k = 0; k < 3; ++k) {
    const Quantiles &qa = solid_[0].values[k], &qb = solid_[1].values[k];
    std::vector<float> middle(qa.at.size());
    for (std::size_t i = 0; i < middle.size(); ++i)
      middle[i] = 0.5 * (qa.at[i] / solid_[0].deviation + qb.at[i] / solid_[1].deviation);
    working_[k] = quantiles_of(middle);
    working_[k].at = std::move(middle);
    working_[k].least = working_[k].at.front();
    working_[k].most = working_[k].at.back();
  }
}

Vec3f ColorMorph::to_working(int solid, const Vec3f& linear) const {
  const Solid& s = solid_[solid];
  const Vec3f values = s.axes.cast<float>().transpose() * (linear_to_oklab(linear) - s.mean);
  Vec3f out;
  for (int k = 0; k < 3; ++k) out[k] = working(k).of(rank_of(s.values[k].at, values[k]));
  return out;
}

Vec3f ColorMorph::to_linear(const Vec3f& value, float w) const {
  Vec3f a, b;
  for (int k = 0; k < 3; ++k) {
    const double rank = rank_of(working(k).at, value[k]);
    a[k] = solid_[0].values[k].of(rank);
    b[k] = solid_[1].values[k].of(rank);
  }
  const Vec3f lab = (1 - w) * (solid_[0].mean + solid_[0].axes.cast<float>() * a) +
                    w * (solid_[1].mean + solid_[1].axes.cast<float>() * b);
  return oklab_to_linear(lab).cwiseMax(0.0f);
}

}  // namespace terrazzo::patch_fill
