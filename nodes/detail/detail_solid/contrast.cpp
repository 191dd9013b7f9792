#include "nodes/detail/detail_solid/contrast.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "nodes/common/geometry/rank.h"
#include "nodes/detail/detail_solid/broad.h"
#include "nodes/detail/detail_solid/rim.h"
#include "nodes/detail/residual/outline_depth.h"

namespace terrazzo::detail_solid {
namespace {

constexpr double kLeastArea = 60;  // pixels of a profile whose contrast counts
constexpr float kBlurred = 2.5f;  // pixels from the outline, within which none tell the contrast of a profile
constexpr double kLeastContrast = 0.03;
constexpr double kGrainArea = 10, kBroadArea = 200;  // pixels that count as one sample of a deviation
constexpr double kPrior = 4;                         // samples of the group that are added to a profile's

// The smallest value that this share of the weight does not exceed. Sorts the values.
float quantile_by_weight(std::vector<std::pair<float, double>>& values, double share) {
  std::sort(values.begin(), values.end());
  double all = 0, below = 0;
  for (const auto& [value, weight] : values) all += weight;
  for (const auto& [value, weight] : values)
    if ((below += weight) >= share * all) return value;
  return values.back().first;
}

// A profile in which hues vary far more than in the others of its group holds two stones, or a stone and
// soil. Its stones would get patches of several hues, so its contrasts of chroma are limited: to 1.3 times
// the median by area, or to what a fifth of the area exceeds.
void limit_chroma(const Detail& detail, std::size_t groups, std::vector<Eigen::Vector2f>& of_profile) {
  for (std::size_t g = 1; g <= groups; ++g) {
    std::vector<std::pair<float, double>> contrast;  // with the profile's area
    for (std::size_t k = 0; k < detail.profile_group.size(); ++k)
      if (detail.profile_group[k] == static_cast<std::int32_t>(g))
        contrast.emplace_back(of_profile[k].y(), std::pow(double{detail.profile_size[k]}, 2));
    if (contrast.empty()) continue;
    const float limit = std::max(1.3f * quantile_by_weight(contrast, 0.5), quantile_by_weight(contrast, 0.8));
    for (std::size_t k = 0; k < detail.profile_group.size(); ++k)
      if (detail.profile_group[k] == static_cast<std::int32_t>(g))
        of_profile[k].y() = std::min(of_profile[k].y(), limit);
  }
}

// Squares of the mean of the channels, and of the rest. One crack or speck of dirt would dominate the mean
// square of a small profile, so the upper quartile of the squares measures its grain.
struct GrainSquares {
  std::vector<float> gray, chroma;
  void add(const Vec2& squares) {
    gray.push_back(squares[0]);
    chroma.push_back(squares[1]);
  }
  Vec2 value() {
    constexpr double kRank = 0.75;
    if (gray.empty()) return Vec2::Zero();
    const std::size_t rank = kRank * (gray.size() - 1);
    return {at_rank(gray, rank), at_rank(chroma, rank)};
  }
};

Vec2 squares_of(const Vec3f& offset) {
  const double mean = offset.mean();
  return Vec2(3 * mean * mean, std::max(0.0, offset.squaredNorm() - 3 * mean * mean));
}

// What contrasts are measured from, of a profile or of a group.
struct ContrastSum {
  double pixels = 0, count = 0;  // all, and those whose grain and broad part are summed
  GrainSquares of_grain, of_finest;
  Vec2 grain = Vec2::Zero(), finest = Vec2::Zero(), broad = Vec2::Zero();
  std::size_t group = 0;

  void add(const Vec3f& grain_offset, const Vec3f& finest_offset, const Vec3f& broad_offset) {
    ++count;
    of_grain.add(squares_of(grain_offset));
    of_finest.add(squares_of(finest_offset));
    broad += squares_of(broad_offset);
  }
  void finish() {
    grain = count * of_grain.value();
    finest = count * of_finest.value();
    of_grain = {};
    of_finest = {};
  }
};

// Difference from the mean of the neighbors in the profile. Only deep pixels are used, so all of these are
// in the same section.
Vec3f finest_offset(const Phases& p, const Labels& labels, const std::vector<Vec3f>& offset, std::size_t i) {
  Vec3f sum = Vec3f::Zero();
  float count = 0;
  for (const std::size_t j : {i - 1, i + 1, i - p.width, i + p.width})
    if (j < p.phase.size() && labels.ids[j] == labels.ids[i] && p.phase[j] > 0) {
      sum += offset[j];
      ++count;
    }
  return count > 0 ? Vec3f(offset[i] - sum / count) : Vec3f::Zero();
}

struct ContrastSums {
  std::vector<ContrastSum> profile, group;
};

// Divides the grain by its gain near outlines, and sums it over profiles and groups.
ContrastSums sum_contrasts(const Phases& p, const Labels& labels, const Detail& detail,
                           const std::vector<Vec3f>& broad, Phases& grain) {
  ContrastSums sums{std::vector<ContrastSum>(static_cast<std::size_t>(labels.count())),
                    std::vector<ContrastSum>(p.group_color.size())};
  const std::vector<Vec3f> before = grain.offset;
  const std::vector<float> depth = depths_of(p, labels);
  for (std::size_t i = 0; i < p.phase.size(); ++i) {
    if (p.phase[i] <= 0) continue;
    if (const auto& gain = detail.phases[p.phase[i]].grain_gain; !gain.empty())
      grain.offset[i] /= gain[bin_of(depth[i], gain.size())];
    ContrastSum& s = sums.profile[static_cast<std::size_t>(labels.ids[i]) - 1];
    s.group = static_cast<std::size_t>(p.phase[i]) - 1;
    ++s.pixels;
    if (depth[i] < kBlurred) continue;  // the blur of the outline counts as grain there
    const Vec3f finest = finest_offset(p, labels, before, i);
    for (ContrastSum* sum : {&s, &sums.group[s.group]}) sum->add(grain.offset[i], finest, broad[i]);
  }
  for (auto* of : {&sums.profile, &sums.group})
    for (ContrastSum& s : *of) s.finish();
  return sums;
}

// A profile counts as `samples` independent ones; those of a group's mean deviation are added to them.
Eigen::Vector2f relative_contrast(const Vec2& own, double count, const Vec2& all, double of_all,
                                  double samples) {
  Eigen::Vector2f out(1, 1);
  for (int a = 0; a < 2; ++a)
    if (all[a] > 1e-9 * all.sum()) {
      const double ratio = own[a] / count / (all[a] / of_all);
      out[a] = std::clamp(std::sqrt((samples * ratio + kPrior) / (samples + kPrior)), kLeastContrast, 3.0);
    }
  return out;
}

Eigen::Vector2f grain_contrast(const ContrastSum& s, const ContrastSum& g) {
  Eigen::Vector2f out(1, 1);
  const double samples = s.count / kGrainArea;
  if (s.count > 0 && g.grain.sum() > 0) out = relative_contrast(s.grain, s.count, g.grain, g.count, samples);
  // The gradient of a dark spot counts as grain, so the contrast of the finest grain limits that of all
  // grain.
  if (s.count > 0 && g.finest.sum() > 0) {
    const auto finest = relative_contrast(s.finest, s.count, g.finest, g.count, samples);
    out = out.cwiseMin(finest.cwiseMax(1.0f));
  }
  return out;
}

Eigen::Vector2f broad_contrast(const ContrastSum& s, const ContrastSum& g) {
  if (!(s.count > 0 && g.broad.sum() > 0)) return {1, 1};
  return relative_contrast(s.broad, s.count, g.broad, g.count, s.count / kBroadArea);
}

Vec3f without_contrast(const Vec3f& offset, const Eigen::Vector2f& contrast) {
  const Vec3f gray = Vec3f::Constant(offset.mean());
  return gray / contrast.x() + (offset - gray) / contrast.y();
}

}  // namespace

void split_contrasts(Phases& p, const Image& image, const Labels& labels, Detail& detail, const Work& work) {
  Phases grain = p;
  const std::vector<Vec3f> broad = split_broad(grain, labels, work.quiet());
  const ContrastSums sums = sum_contrasts(p, labels, detail, broad, grain);
  const std::vector<float> size = residual::sizes_of_particles(labels.ids, image.pixel_size);
  std::vector<Eigen::Vector2f> of_grain(sums.profile.size(), Eigen::Vector2f(1, 1)), of_broad = of_grain;
  for (std::size_t k = 0; k < sums.profile.size(); ++k) {
    const ContrastSum& s = sums.profile[k];
    const ContrastSum& g = sums.group[s.group];
    if (s.pixels < kLeastArea || !((g.grain + g.broad).sum() > 0)) continue;
    of_grain[k] = grain_contrast(s, g);
    of_broad[k] = broad_contrast(s, g);
    detail.profile_color.push_back(p.profile_color[k]);
    detail.profile_group.push_back(static_cast<std::int32_t>(s.group) + 1);
    detail.profile_contrast.push_back(of_grain[k]);
    detail.profile_broad.push_back(of_broad[k]);
    detail.profile_size.push_back(size[k + 1]);
  }
  limit_chroma(detail, p.group_color.size(), detail.profile_contrast);
  limit_chroma(detail, p.group_color.size(), detail.profile_broad);
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] > 0) {
      const std::size_t k = static_cast<std::size_t>(labels.ids[i]) - 1;
      p.offset[i] = without_contrast(grain.offset[i], of_grain[k]) + without_contrast(broad[i], of_broad[k]);
    }
}

}  // namespace terrazzo::detail_solid
