#include "nodes/detail/detail_solid/zones.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "nodes/common/geometry/rank.h"
#include "nodes/data/indices.h"
#include "nodes/detail/detail_solid/broad.h"
#include "nodes/detail/residual/outline_depth.h"
#include "runtime/random.h"

namespace terrazzo::detail_solid {
namespace {

constexpr double kDistinct = 0.77;   // share of the variance that two levels explain
constexpr double kLeastShare = 0.1;  // of each zone
constexpr float kBlur = 1.5f;        // pixels, of the lightness that is compared with the threshold
constexpr int kBetween = 2;          // pixels on each side of an edge between zones
constexpr double kLeastWidth = 4;    // pixels over which the covariance falls to one half
// Least deviation of the field, relative to that width: finer structure would fray all edges.
constexpr double kSmooth = 0.25;
constexpr float kLeastContrast = 0.03f, kFlat = 0.3f;  // deviations relative to the other zone's
constexpr std::size_t kEnoughLeft = 4000;              // used pixels of the binder
constexpr int kLevels = 64;                            // pixels from the outline
constexpr double kLeastInBin = 400;                    // pixels
constexpr std::array kApart = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96};                // pixels
constexpr std::array kWidths = {2.0f, 3.0f, 4.5f, 7.0f, 10.0f, 15.0f, 22.0f, 33.0f, 50.0f};  // pixels
constexpr int kPairsEach = 4000;  // of pixels, at each distance
constexpr int kSteps = 40;        // of the correlation

float median_or(std::vector<float> values, float none) {
  return values.empty() ? none : median(std::move(values));
}

double share_below(double level) { return 0.5 * std::erfc(-level / std::numbers::sqrt2); }

// The level that a standard normal variable is below with this probability.
double level_of(double share) {
  double low = -4, high = 4;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (low + high);
    (share_below(middle) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// The binder's lightness, blurred over its used pixels.
std::vector<float> blurred_lightness(const Phases& p) {
  std::vector<float> out(p.phase.size(), 0.0f);
  for (int s = 0; s < p.sections; ++s) {
    const std::size_t first = s * p.plane();
    cv::Mat sum(p.height, p.width, CV_32F, cv::Scalar(0)), weight(p.height, p.width, CV_32F, cv::Scalar(0));
    for (std::size_t i = 0; i < p.plane(); ++i)
      if (p.phase[first + i] == 0) {
        sum.ptr<float>()[i] = p.offset[first + i].mean();
        weight.ptr<float>()[i] = 1;
      }
    cv::GaussianBlur(sum, sum, {0, 0}, kBlur, kBlur, cv::BORDER_CONSTANT);
    cv::GaussianBlur(weight, weight, {0, 0}, kBlur, kBlur, cv::BORDER_CONSTANT);
    for (std::size_t i = 0; i < p.plane(); ++i)
      if (p.phase[first + i] == 0) out[first + i] = sum.ptr<float>()[i] / weight.ptr<float>()[i];
  }
  return out;
}

struct Threshold {
  float value = 0;
  double explained = 0, below = 0;  // shares of the variance and of the pixels
};

Threshold threshold_of(std::vector<float> values) {
  Threshold best;
  std::sort(values.begin(), values.end());
  const double n = values.size();
  double all = 0, square = 0, sum = 0;
  for (const float v : values) {
    all += v;
    square += static_cast<double>(v) * v;
  }
  const double variance = square / n - all * all / (n * n);
  if (!(variance > 1e-9)) return best;
  for (std::size_t k = 1; k < values.size(); ++k) {
    sum += values[k - 1];
    if (values[k] == values[k - 1]) continue;
    const double w = k / n, apart = sum / k - (all - sum) / (n - k),
                 explained = w * (1 - w) * apart * apart / variance;
    if (explained > best.explained) best = {0.5f * (values[k] + values[k - 1]), explained, w};
  }
  return best;
}

// Levels where `place` is i + ½ pixels, from places within a quarter of it, and more if these have few
// pixels. The blur of an outline looks like the light zone, so no pixel within it counts.
std::vector<float> levels_of(const Phases& p, const std::vector<float>& place,
                             const std::vector<float>& depth, double softness) {
  std::vector<double> low(kLevels, 0), all(kLevels, 0);
  for (std::size_t i = 0; i < p.zone.size(); ++i)
    if (p.zone[i] > 0 && depth[i] > 1 + 2.5 * softness) {
      const std::size_t k = std::min(place[i], kLevels - 1.0f);
      low[k] += p.zone[i] == 1;
      ++all[k];
    }
  std::vector<float> levels(kLevels, 0.0f);
  for (std::size_t k = 0; k < levels.size(); ++k) {
    double l = low[k], a = all[k];
    for (std::size_t d = 1; (a < kLeastInBin || 4 * d <= k) && d < levels.size(); ++d) {
      if (k >= d) {
        l += low[k - d];
        a += all[k - d];
      }
      if (k + d < levels.size()) {
        l += low[k + d];
        a += all[k + d];
      }
    }
    levels[k] = level_of(std::clamp(l / std::max(a, 1.0), 0.002, 0.998));
  }
  return levels;
}

// The field's correlation at each of kApart: that which makes two pixels dark as often as in the photograph.
std::vector<double> correlations(const Phases& p, const std::vector<float>& width,
                                 const std::vector<float>& levels, std::uint64_t seed) {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < p.zone.size(); ++i)
    if (p.zone[i] > 0) used.push_back(i);
  std::vector<double> out;
  Random random(seed, 0x7a6f6e65);
  for (const int r : kApart) {
    double both = 0, pairs = 0;
    std::array<double, kSteps + 1> expected{};  // by correlation, from 0 to 1
    for (int n = 0; n < 20 * kPairsEach && pairs < kPairsEach; ++n) {
      const std::size_t i = used[random.below(used.size())];
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      const int in = i % p.plane();
      const int x = in % p.width + round_nearest(r * std::cos(angle)),
                y = in / p.width + round_nearest(r * std::sin(angle));
      if (x < 0 || y < 0 || x >= p.width || y >= p.height) continue;
      const std::size_t j = i - static_cast<std::size_t>(in) + pixel_at(x, y, p.width);
      if (p.zone[j] == 0) continue;
      both += p.zone[i] == 1 && p.zone[j] == 1;
      ++pairs;
      const double a = Detail::at_distance(levels, width[i]), b = Detail::at_distance(levels, width[j]);
      double sum = share_below(a) * share_below(b);
      expected[0] += sum;
      for (int k = 1; k <= kSteps; ++k) {  // the bivariate normal density, integrated over the correlation
        const double c = (k - 0.5) / kSteps, d = 1 - c * c;
        sum += std::exp(-(a * a - 2 * c * a * b + b * b) / (2 * d)) /
               (2 * std::numbers::pi * std::sqrt(d) * kSteps);
        expected[k] += sum;
      }
    }
    std::size_t k = 0;
    while (k < kSteps && expected[k + 1] < both) ++k;
    const double step = k < kSteps ? expected[k + 1] - expected[k] : 1;
    out.push_back(pairs < kPairsEach / 10.0
                      ? -1
                      : std::min(1.0, (k + std::clamp((both - expected[k]) / step, 0.0, 1.0)) / kSteps));
  }
  return out;
}

std::vector<float> widths_of(const Phases& p, const Labels& labels, const Work& work) {
  std::vector<float> all;
  for (int s = 0; s < p.sections; ++s) {
    const auto one = residual::binder_width(&labels.ids[s * p.plane()], p.width, p.height, false, 1, work);
    all.insert(all.end(), one.begin(), one.end());
  }
  return all;
}

// Marks the pixels near an edge between zones in one section.
std::vector<std::uint8_t> near_edges(const Phases& p, std::size_t first) {
  cv::Mat dark(p.height, p.width, CV_8U, cv::Scalar(0)), light = dark.clone();
  for (std::size_t i = 0; i < p.plane(); ++i) {
    dark.data[i] = p.zone[first + i] == 1;
    light.data[i] = p.zone[first + i] == 2;
  }
  const cv::Mat around = cv::Mat::ones(2 * kBetween + 1, 2 * kBetween + 1, CV_8U);
  cv::dilate(dark, dark, around);
  cv::dilate(light, light, around);
  std::vector<std::uint8_t> out(p.plane());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = dark.data[i] && light.data[i];
  return out;
}

// Numbers the zone of each of the binder's pixels. False if there are no two zones.
bool number_zones(Phases& p) {
  const std::vector<float> lightness = blurred_lightness(p);
  std::vector<float> values;
  for (std::size_t i = 0; i < lightness.size(); ++i)
    if (p.phase[i] == 0) values.push_back(lightness[i]);
  const Threshold threshold = threshold_of(std::move(values));
  if (threshold.explained < kDistinct || std::min(threshold.below, 1 - threshold.below) < kLeastShare)
    return false;
  p.zone.assign(p.phase.size(), 0);
  for (std::size_t i = 0; i < lightness.size(); ++i)
    if (p.phase[i] == 0) p.zone[i] = lightness[i] < threshold.value ? 1 : 2;
  return true;
}

// Stores the field whose covariance comes closest. False if it is as fine as grain.
bool fit_field(const std::vector<double>& correlation, Detail::Zones& zones) {
  Eigen::MatrixXd a(kApart.size(), kWidths.size());
  Eigen::VectorXd b(kApart.size());
  double width = 0;
  for (std::size_t i = 0; i < kApart.size(); ++i)
    if (correlation[i] >= 0.5) width = kApart[i];
  for (std::size_t i = 0; i < kApart.size(); ++i) {
    const Eigen::Index row = i;
    const bool known = correlation[i] >= 0;
    for (std::size_t k = 0; k < kWidths.size(); ++k)
      a(row, k) = known && kWidths[k] >= kSmooth * width
                      ? std::exp(-kApart[i] * kApart[i] / (4.0 * kWidths[k] * kWidths[k]))
                      : 0;
    b[row] = known ? correlation[i] : 0;
  }
  const Eigen::VectorXd variance = nonnegative_fit(a, b);
  if (width < kLeastWidth || !(variance.sum() > 0)) return false;
  for (std::size_t k = 0; k < kWidths.size(); ++k)
    if (const double v = variance[k] / variance.sum(); v > 1e-3) {
      zones.sigma.push_back(kWidths[k]);
      zones.variance.push_back(v);
    }
  return true;
}

// Medians: what blurs into a zone of air from outlines must not make it gray.
void find_zone_levels(const Phases& p, const std::vector<std::uint8_t>& between, Detail::Zones& zones) {
  std::array<std::vector<float>, 2> of_zone[3];  // of each channel
  for (std::size_t i = 0; i < p.zone.size(); ++i)
    if (p.zone[i] > 0 && !between[i])
      for (int c = 0; c < 3; ++c) of_zone[c][p.zone[i] - 1].push_back(p.offset[i][c]);
  for (int c = 0; c < 3; ++c) {
    zones.dark[c] = median_or(std::move(of_zone[c][0]), 0);
    zones.light[c] = median_or(std::move(of_zone[c][1]), 0);
  }
}

}  // namespace

void split_zones(Phases& p, const Labels& labels, Detail& detail, std::uint64_t seed, const Work& work) {
  if (p.pixels[0] < kEnoughLeft || !number_zones(p)) return;
  const std::vector<float> depth = outlines_of(p, labels).depth, width = widths_of(p, labels, work);
  Detail::Zones zones;
  zones.level = levels_of(p, depth, depth, detail.softness);
  zones.level_by_width = levels_of(p, width, depth, detail.softness);
  const double dark = std::count(p.zone.begin(), p.zone.end(), 1), all = p.pixels[0];
  zones.mean_level = level_of(std::clamp(dark / all, 0.002, 0.998));
  if (!fit_field(correlations(p, width, zones.level_by_width, seed), zones)) {
    p.zone.clear();
    return;
  }
  std::vector<std::uint8_t> between;
  for (int s = 0; s < p.sections; ++s) {
    const auto one = near_edges(p, s * p.plane());
    between.insert(between.end(), one.begin(), one.end());
  }
  find_zone_levels(p, between, zones);
  std::size_t left = p.pixels[0];
  for (std::size_t i = 0; i < p.zone.size(); ++i) left -= p.zone[i] > 0 && between[i];
  for (std::size_t i = 0; i < p.zone.size(); ++i) {
    if (p.zone[i] == 0) continue;
    p.offset[i] -= p.zone[i] == 1 ? zones.dark : zones.light;
    if (between[i] && left >= kEnoughLeft) {
      p.phase[i] = -1;
      p.zone[i] = 0;
      p.offset[i].setZero();
      --p.pixels[0];
    }
  }
  detail.zones = std::move(zones);
}

void split_zone_contrasts(Phases& p, Detail& detail) {
  if (p.zone.empty()) return;
  std::vector<float> size[2];
  const auto each = [&](auto&& use) {
    for (std::size_t i = 0; i < p.zone.size(); ++i)
      if (p.phase[i] == 0 && p.zone[i] > 0) use(i, static_cast<std::size_t>(p.zone[i] - 1));
  };
  each([&](std::size_t i, std::size_t z) { size[z].push_back(p.offset[i].norm()); });
  const float deviation[2] = {median_or(size[0], 0), median_or(size[1], 0)};
  const float most = std::max(deviation[0], deviation[1]);
  if (!(most > 0)) return;
  float contrast[2];
  for (int z = 0; z < 2; ++z) {
    contrast[z] = std::max(deviation[z] / most, kLeastContrast);
    // Enlarged, what little a flat zone has would dominate the tile.
    if (deviation[z] >= kFlat * most || size[1 - z].size() < kEnoughLeft) continue;
    each([&](std::size_t i, std::size_t zone) {
      if (zone != static_cast<std::size_t>(z)) return;
      p.phase[i] = -1;
      p.offset[i].setZero();
      --p.pixels[0];
    });
  }
  each([&](std::size_t i, std::size_t z) { p.offset[i] /= contrast[z]; });
  detail.zones.dark_contrast = contrast[0];
  detail.zones.light_contrast = contrast[1];
}

}  // namespace terrazzo::detail_solid
