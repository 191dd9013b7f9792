#include "nodes/compare/texture_observer/pattern_features.h"

#include <algorithm>
#include <cmath>

#include "nodes/compare/texture_observer/local_patterns.h"
#include "nodes/data/indices.h"

namespace terrazzo::texture_observer {

namespace {

constexpr int kEdgeBins = 8, kDirections = 8;
constexpr std::array<int, 2> kEdgeSteps{1, 2};
constexpr std::array<int, 4> kBandSteps{1, 2, 4, 8};
constexpr std::array<int, 2> kColorSteps{1, 2};
constexpr std::array<int, 3> kRadii{1, 2, 4};
constexpr std::array<double, 7> kRanks{0.02, 0.1, 0.25, 0.5, 0.75, 0.9, 0.98};

// What a pixel contributes, computed once for all crops of its cell.
struct EdgeMap {
  std::vector<float> strength;
  std::vector<std::uint8_t> bin, direction;
};

EdgeMap edges_of(const Patch& p, int step) {
  EdgeMap out;
  out.strength.assign(p.lab.size(), 0);
  out.bin.assign(p.lab.size(), 0);
  out.direction = out.bin;
  for (int y = step; y < p.height - step; ++y)
    for (int x = step; x < p.width - step; ++x) {
      const float u = p.at(x + step, y)[0] - p.at(x - step, y)[0],
                  v = p.at(x, y + step)[0] - p.at(x, y - step)[0], strength = std::hypot(u, v);
      const std::size_t i = pixel_at(x, y, p.width);
      out.strength[i] = strength;
      const float octave = std::log2(std::max(strength, 1e-6f) / 0.004f);
      out.bin[i] = static_cast<std::uint8_t>(std::clamp(std::floor(octave) + 1, 0.0f, kEdgeBins - 1.0f));
      // Centered bins: exact horizontals and verticals, common at 8 bits, are not at the border of two.
      const double turn = std::atan2(v, u) / M_PI + 1 + 0.5 / kDirections;
      out.direction[i] = static_cast<int>(turn * kDirections) % kDirections;
    }
  return out;
}

double quantile_of(const std::vector<float>& sorted, double u) {
  return sorted[std::lround(u * (sorted.size() - 1))];
}

// One crop within its cell, and the row of features that is being filled.
struct Reader {
  const Patch& patch;
  int x0, y0, crop;
  Eigen::VectorXd row;
  Eigen::Index filled = 0;

  void put(double value) { row[filled++] = value; }
  template <class F>
  void each(int margin, const F& f) const {
    for (int y = y0 + margin; y < y0 + crop - margin; ++y)
      for (int x = x0 + margin; x < x0 + crop - margin; ++x) f(pixel_at(x, y, patch.width));
  }
  // Mean square of second differences.
  double roughness(int channel, int step) const {
    double sum = 0;
    const std::size_t across = step, down = across * patch.width;
    each(step, [&](std::size_t i) {
      const auto v = [&](std::size_t k) { return patch.lab[k][channel]; };
      const float a = v(i - across) - 2 * v(i) + v(i + across), b = v(i - down) - 2 * v(i) + v(i + down);
      sum += a * a + b * b;
    });
    return sum / ((crop - 2.0 * step) * (crop - 2.0 * step));
  }
};

void put_lightness(Reader& r) {
  std::vector<float> light;
  r.each(0, [&](std::size_t i) { light.push_back(r.patch.lab[i][0]); });
  std::sort(light.begin(), light.end());
  const double n = light.size();
  double mean = 0, square = 0, cube = 0;
  for (float v : light) mean += v / n;
  for (float v : light) {
    square += (v - mean) * (v - mean) / n;
    cube += std::pow(v - mean, 3) / n;
  }
  r.put(mean);
  r.put(std::sqrt(square));
  r.put(cube / std::pow(square + kRoundingVariance, 1.5));
  for (double u : kRanks) r.put(quantile_of(light, u));
}

void put_color(Reader& r) {
  std::vector<float> chroma;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d product = Eigen::Matrix3d::Zero();
  r.each(0, [&](std::size_t i) {
    const Eigen::Vector3d c = r.patch.lab[i].cast<double>();
    mean += c;
    product += c * c.transpose();
    chroma.push_back(std::hypot(c[1], c[2]));
  });
  const double n = chroma.size();
  mean /= n;
  const Eigen::Matrix3d covariance = product / n - mean * mean.transpose();
  const Eigen::Array3d deviation = covariance.diagonal().array().max(0).sqrt();
  r.put(mean[1]);
  r.put(mean[2]);
  r.put(deviation[1]);
  r.put(deviation[2]);
  for (const auto& [i, j] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)})
    r.put(covariance(i, j) / (deviation[i] * deviation[j] + kRoundingVariance));
  std::sort(chroma.begin(), chroma.end());
  for (double u : {0.1, 0.5, 0.9}) r.put(quantile_of(chroma, u));
}

// Square roots of frequencies: their spread does not depend on how frequent they are.
template <class Bins>
void put_histogram(Reader& r, int bins, int margin, const Bins& bin, const float* weight = nullptr) {
  Eigen::ArrayXd counts = Eigen::ArrayXd::Zero(bins);
  r.each(margin, [&](std::size_t i) { counts[bin[i]] += weight ? weight[i] : 1; });
  const double sum = counts.sum();
  for (int k = 0; k < bins; ++k) r.put(sum > 0 ? std::sqrt(counts[k] / sum) : std::sqrt(1.0 / bins));
}

}  // namespace

const std::vector<FeatureGroup>& pattern_groups() {
  static const std::vector<FeatureGroup> groups = [] {
    std::vector<FeatureGroup> g;
    const auto add = [&](const char* name, std::size_t count) {
      g.push_back({name, g.empty() ? 0 : g.back().first + g.back().count, static_cast<int>(count)});
    };
    add("lightness", 3 + kRanks.size());
    add("color", 10);
    add("edges", kEdgeSteps.size() * kEdgeBins);
    add("direction", kEdgeSteps.size() * kDirections);
    add("sharpness", kBandSteps.size());
    add("color detail", 2 * kColorSteps.size());
    add("local patterns", kRadii.size() * kLocalPatterns);
    return g;
  }();
  return groups;
}

Eigen::MatrixXd pattern_features(const CropSet& set, const Work& work) {
  const int width = pattern_groups().back().first + pattern_groups().back().count;
  Eigen::MatrixXd out(set.crops.size(), width);
  std::vector<std::size_t> first(set.cells.size() + 1, set.crops.size());
  for (std::size_t i = set.crops.size(); i-- > 0;) first[set.crops[i].cell] = i;
  work.parallel(set.cells.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const Patch& patch = set.cells[c].levels[0];
      std::vector<EdgeMap> edges;
      for (int step : kEdgeSteps) edges.push_back(edges_of(patch, step));
      std::vector<std::vector<std::uint8_t>> patterns;
      for (int radius : kRadii) patterns.push_back(local_patterns(patch, radius));
      for (std::size_t i = first[c]; i < first[c + 1]; ++i) {
        Reader r{patch, set.crops[i].x, set.crops[i].y, set.crop, Eigen::VectorXd(width)};
        put_lightness(r);
        put_color(r);
        for (std::size_t k = 0; k < kEdgeSteps.size(); ++k)
          put_histogram(r, kEdgeBins, kEdgeSteps[k], edges[k].bin);
        for (std::size_t k = 0; k < kEdgeSteps.size(); ++k)
          put_histogram(r, kDirections, kEdgeSteps[k], edges[k].direction, edges[k].strength.data());
        for (int step : kBandSteps) r.put(std::log(r.roughness(0, step) + kRoundingVariance));
        for (int step : kColorSteps)
          for (int channel : {1, 2}) r.put(std::log(r.roughness(channel, step) + kRoundingVariance));
        for (std::size_t k = 0; k < kRadii.size(); ++k)
          put_histogram(r, kLocalPatterns, kRadii[k], patterns[k]);
        out.row(i) = r.row;
      }
    }
  });
  return out;
}

}  // namespace terrazzo::texture_observer
