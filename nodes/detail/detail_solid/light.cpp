#include "nodes/detail/detail_solid/light.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/detail/residual/outline_depth.h"

namespace terrazzo::detail_solid {
namespace {

constexpr double kLeastTilted = 60;  // pixels of a profile whose slope counts
constexpr double kLeastLit = 400;    // pixels of a bin
constexpr float kNear = 8;           // pixels from the outline that tell whether there is light
constexpr int kFade = 8;             // bins over which it fades

// Directions of several profiles, and how sure their mean is.
struct Directions {
  std::vector<std::pair<Vec2, double>> of_profile;  // with its weight
  void add(const Vec2& v, double weight) {
    if (weight > 0) of_profile.emplace_back(v, weight);
  }
  Vec2 mean() const {
    Vec2 sum = Vec2::Zero();
    double weight = 0;
    for (const auto& [v, w] : of_profile) {
      sum += w * v;
      weight += w;
    }
    return weight > 0 ? Vec2(sum / weight) : Vec2(Vec2::Zero());
  }
  // The share of the mean that is not chance, from 0 to 1.
  double certainty() const {
    if (of_profile.size() < 3) return 0;
    const Vec2 m = mean();
    double error = 0, weight = 0;
    for (const auto& [v, w] : of_profile) {
      error += w * w * (v - m).squaredNorm();
      weight += w;
    }
    const double square = m.squaredNorm();
    return square > 0 ? std::max(0.0, 1 - error / (weight * weight) / square) : 0;
  }
};

// Sums for the plane that fits values over points.
struct PlaneFit {
  double n = 0, xx = 0, xy = 0, yy = 0;
  Vec2 x = Vec2::Zero();
  Vec3 v = Vec3::Zero(), vx = Vec3::Zero(), vy = Vec3::Zero();
  void add(const Vec2& at, const Vec3& value) {
    ++n;
    x += at;
    xx += at.x() * at.x();
    xy += at.x() * at.y();
    yy += at.y() * at.y();
    v += value;
    vx += at.x() * value;
    vy += at.y() * value;
  }
  Vec2 center() const { return x / std::max(n, 1.0); }
  // Slopes to the right and upwards, in columns; zero where the points do not tell.
  Eigen::Matrix<double, 3, 2> slopes() const {
    Eigen::Matrix<double, 3, 2> out = Eigen::Matrix<double, 3, 2>::Zero();
    if (n < 3) return out;
    const Vec2 m = center();
    const double a = xx / n - m.x() * m.x(), b = xy / n - m.x() * m.y(), d = yy / n - m.y() * m.y();
    const double det = a * d - b * b;
    if (!(det > 1e-6 * std::max(1e-12, a * d))) return out;
    const Vec3 right = vx / n - m.x() * v / n, up = vy / n - m.y() * v / n;
    out.col(0) = (right * d - up * b) / det;
    out.col(1) = (up * a - right * b) / det;
    return out;
  }
};

void split_tilts(Phases& p, const Labels& labels, Detail& detail) {
  const auto place = [&](std::size_t i) {
    const std::size_t in = i % p.plane(), w = p.width;
    return Vec2(static_cast<double>(in % w), -static_cast<double>(in / w));
  };
  std::vector<PlaneFit> fits(labels.count());
  std::vector<int> group(fits.size(), 0);
  const auto each = [&](auto&& use) {
    for (std::size_t i = 0; i < p.phase.size(); ++i)
      if (p.phase[i] > 0) use(i, static_cast<std::size_t>(labels.ids[i]) - 1);
  };
  each([&](std::size_t i, std::size_t k) {
    fits[k].add(place(i), Vec3::Constant(p.offset[i].mean()));
    group[k] = p.phase[i];
  });
  std::vector<Directions> tilts(detail.phases.size());
  for (std::size_t k = 0; k < fits.size(); ++k)
    if (group[k] > 0 && fits[k].n >= kLeastTilted)
      tilts[group[k]].add(std::sqrt(fits[k].n / std::numbers::pi) * fits[k].slopes().row(0).transpose(),
                          fits[k].n);
  for (std::size_t g = 1; g < tilts.size(); ++g)
    detail.phases[g].tilt = (tilts[g].certainty() * tilts[g].mean()).cast<float>();
  each([&](std::size_t i, std::size_t k) {
    if (fits[k].n < kLeastTilted) return;
    const Vec2 across = (place(i) - fits[k].center()) / std::sqrt(fits[k].n / std::numbers::pi);
    p.offset[i] -=
        Vec3f::Constant(static_cast<float>(across.dot(detail.phases[group[k]].tilt.cast<double>())));
  });
}

// Fades out over the last bins, if these are far from outlines.
void fade(std::vector<Vec3f>& values, std::size_t bins) {
  if (values.size() < bins) return;
  for (int k = 0; k < kFade; ++k) values[bins - 1 - k] *= static_cast<float>(k) / kFade;
}

void smooth(std::vector<Vec3f>& values) {
  const std::vector<Vec3f> raw = values;
  const int n = values.size();
  for (int i = 2; i < n; ++i) {
    const int reach = std::min({i < 8 ? 1 : 2, n - 1 - i});
    Vec3f sum = Vec3f::Zero();
    for (int k = i - reach; k <= i + reach; ++k) sum += raw[k];
    values[i] = sum / static_cast<float>(2 * reach + 1);
  }
}

void split_phase(Phases& p, int phase, const residual::Outlines& outlines, const std::vector<float>& sizes,
                 std::vector<Detail::Rim>& rims) {
  if (rims.empty()) return;  // too few pixels
  const auto size_at = [&](std::size_t i) { return sizes[outlines.particle[i]]; };
  const auto each = [&](auto&& use) {
    for (std::size_t i = 0; i < p.phase.size(); ++i)
      if (p.phase[i] == phase && size_at(i) > 0) use(i);
  };
  const auto rim_of = [&](float size) {
    std::size_t r = 0;
    while (r + 1 < rims.size() && size * size > rims[r].size * rims[r + 1].size) ++r;
    return r;
  };
  std::size_t longest = 0;
  for (const Detail::Rim& rim : rims) longest = std::max(longest, rim.offset.size());
  std::vector<std::vector<PlaneFit>> bins(rims.size(), std::vector<PlaneFit>(longest));
  std::vector<std::vector<std::pair<Vec2, double>>> near(
      rims.size(), std::vector<std::pair<Vec2, double>>(sizes.size(), {Vec2::Zero(), 0.0}));
  each([&](std::size_t i) {
    const std::size_t r = rim_of(size_at(i));
    const Vec2 normal = outlines.normal[i].cast<double>();
    const std::size_t bin = outlines.depth[i];
    if (bin < rims[r].offset.size()) bins[r][bin].add(normal, p.offset[i].cast<double>());
    if (outlines.depth[i] < kNear) {
      auto& [sum, weight] = near[r][outlines.particle[i]];
      sum += p.offset[i].mean() * normal;
      weight += normal.squaredNorm() / 2;
    }
  });
  for (std::size_t r = 0; r < rims.size(); ++r) {
    Directions light;
    for (const auto& [sum, weight] : near[r]) light.add(sum / std::max(weight, 1e-12), weight);
    const double certainty = light.certainty();
    if (!(certainty > 0)) continue;
    Detail::Rim& rim = rims[r];
    rim.right.assign(rim.offset.size(), Vec3f::Zero());
    rim.up = rim.right;
    for (std::size_t k = rim.offset.size(); k-- > 0;) {
      if (bins[r][k].n >= kLeastLit) {
        const Eigen::Matrix<float, 3, 2> s = (certainty * bins[r][k].slopes()).cast<float>();
        rim.right[k] = s.col(0);
        rim.up[k] = s.col(1);
      } else if (k + 1 < rim.offset.size()) {
        rim.right[k] = rim.right[k + 1];
        rim.up[k] = rim.up[k + 1];
      }
    }
    for (auto* values : {&rim.right, &rim.up}) {
      smooth(*values);
      fade(*values, 32);
    }
  }
  each([&](std::size_t i) {
    p.offset[i] -= Detail::light_at(rims, outlines.depth[i], size_at(i), outlines.normal[i]);
  });
}

}  // namespace

void split_light(Phases& p, const Labels& labels, Detail& detail) {
  split_tilts(p, labels, detail);
  const residual::Outlines all = outlines_of(p, labels);
  const std::vector<float> sizes = residual::sizes_of_particles(labels.ids, detail.pixel_size);
  for (std::size_t k = 0; k < detail.phases.size(); ++k) split_phase(p, k, all, sizes, detail.phases[k].rims);
}

}  // namespace terrazzo::detail_solid
