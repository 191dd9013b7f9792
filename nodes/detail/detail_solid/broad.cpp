#include "nodes/detail/detail_solid/broad.h"

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kReach = 48;                                         // pixels
constexpr int kPairs = 400'000;                                    // of pixels
constexpr std::array kSigmas = {4.0, 6.0, 9.0, 13.0, 20.0, 30.0};  // pixels

struct Extent {
  int x0 = 1 << 30, y0 = 1 << 30, x1 = -1, y1 = -1;  // inclusive
};

// The mean of `value` around each used pixel of one label, within the label's extent, over pixels for which
// `counts(pixel)`. Keeps what is there already where hardly any counts.
void blur_label(const Phases& p, const Labels& labels, int section, std::int32_t id, const Extent& e,
                double sigma, const std::vector<Vec3f>& value, const auto& counts,
                std::vector<Vec3f>& broad) {
  constexpr float kLeast = 0.02f;  // weight of the pixels that count
  const int w = e.x1 - e.x0 + 1, h = e.y1 - e.y0 + 1;
  cv::Mat sum(h, w, CV_32FC4, cv::Scalar::all(0));
  const auto each = [&](auto&& use) {
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const std::size_t i = section * p.plane() + static_cast<std::size_t>(e.y0 + y) * p.width + e.x0 + x;
        if (labels.ids[i] == id && p.phase[i] >= 0) use(i, sum.at<cv::Vec4f>(y, x));
      }
  };
  each([&](std::size_t i, cv::Vec4f& v) {
    const Vec3f& o = value[i];
    if (counts(i)) v = cv::Vec4f(o.x(), o.y(), o.z(), 1);
  });
  cv::GaussianBlur(sum, sum, {0, 0}, sigma, sigma, cv::BORDER_CONSTANT);
  each([&](std::size_t i, const cv::Vec4f& v) {
    if (v[3] > kLeast) broad[i] = Vec3f(v[0], v[1], v[2]) / v[3];
  });
}

void blur_labels(const Phases& phases, const Labels& labels, double sigma, const std::vector<Vec3f>& value,
                 const auto& counts, std::vector<Vec3f>& broad, const Work& work) {
  std::vector<Extent> extents(labels.count());
  for (int s = 0; s < phases.sections; ++s) {
    work.check();
    std::fill(extents.begin(), extents.end(), Extent());
    for (int y = 0; y < phases.height; ++y)
      for (int x = 0; x < phases.width; ++x) {
        const std::int32_t id = labels.ids[labels.index(x, y, s)];
        if (id <= 0) continue;
        Extent& e = extents[id - 1];
        e.x0 = std::min(e.x0, x);
        e.x1 = std::max(e.x1, x);
        e.y0 = std::min(e.y0, y);
        e.y1 = std::max(e.y1, y);
      }
    blur_label(phases, labels, s, 0, {0, 0, phases.width - 1, phases.height - 1}, sigma, value, counts,
               broad);
    for (std::size_t k = 0; k < extents.size(); ++k)
      if (extents[k].x1 >= 0)
        blur_label(phases, labels, s, static_cast<std::int32_t>(k) + 1, extents[k], sigma, value, counts,
                   broad);
  }
}

// Robust standard deviations of each phase's offsets from `broad`, at least a step of 8 bits, and at least
// the noise that was taken out: in the photograph, nothing weaker stands out.
std::vector<Vec3f> deviations(const Phases& p, const std::vector<Vec3f>& broad) {
  std::vector<Vec3f> out(p.pixels.size(), Vec3f::Zero());
  std::vector<float> v;
  for (std::size_t phase = 0; phase < out.size(); ++phase) {
    const float least = p.noise.empty() ? 0.004f : std::max(0.004f, p.noise[phase]);
    for (int c = 0; c < 3; ++c) {
      v.clear();
      for (std::size_t i = 0; i < p.phase.size(); ++i)
        if (p.phase[i] == static_cast<int>(phase)) v.push_back(std::abs(p.offset[i][c] - broad[i][c]));
      out[phase][c] = v.empty() ? 0 : std::max(1.4826f * median(v), least);
    }
  }
  return out;
}

// Pixels around one that may belong to its zone.
constexpr int kAroundEdge = 8;

// Weights of the pixels around one, row by row.
std::vector<float> weights_around_edge() {
  std::vector<float> weight;
  for (int dy = -kAroundEdge; dy <= kAroundEdge; ++dy)
    for (int dx = -kAroundEdge; dx <= kAroundEdge; ++dx)
      weight.push_back(std::exp(-0.5 * (dx * dx + dy * dy) / (kBroad * kBroad)));
  return weight;
}

struct EdgeZone {
  Vec3f mean;
  float share = 0;  // of the pixels around
};

// The zone most like a pixel of this row, by mean shift. `deviation`: of the pixel's phase.
EdgeZone zone_at(const Phases& p, const Labels& labels, const std::vector<Vec3f>& soft,
                 const std::vector<float>& weight, const Vec3f& deviation, std::size_t row, int x) {
  constexpr float kRange = 2;  // of the phase's deviations, within one zone
  const int y = row % p.height;
  const std::size_t plane = row / p.height * p.plane(), i = plane + pixel_at(x, y, p.width);
  EdgeZone zone{soft[i]};
  for (int round = 0; round < 3; ++round) {
    Vec3f sum = Vec3f::Zero();
    float total = 0, near = 0;
    for (int v = std::max(0, y - kAroundEdge); v <= std::min(p.height - 1, y + kAroundEdge); ++v)
      for (int u = std::max(0, x - kAroundEdge); u <= std::min(p.width - 1, x + kAroundEdge); ++u) {
        const std::size_t j = plane + pixel_at(u, v, p.width);
        if (p.phase[j] < 0 || labels.ids[j] != labels.ids[i]) continue;
        const float w = weight[static_cast<std::size_t>(v - y + kAroundEdge) * (2 * kAroundEdge + 1) +
                               (u - x + kAroundEdge)];
        const float apart =
            ((soft[j] - zone.mean).array() / deviation.array()).square().sum() / (kRange * kRange);
        const float same = w * std::exp(-0.5f * apart);
        sum += same * p.offset[j];
        total += same;
        near += w;
      }
    if (!(total > 0)) break;
    zone.mean = sum / total;
    zone.share = total / near;
  }
  return zone;
}

// Where zones border on each other, the Gaussian filter leaves their edge in the fine part, from where it
// would float among zones that it does not belong to. There, a pixel takes the mean of the zone that is most
// like it (mean shift, Comaniciu and Meer 2002), unless that zone is a speck. Pixels that lie between zones
// are not used any more, if enough others of their phase are left.
void keep_edges(Phases& p, const Labels& labels, const std::vector<Vec3f>& deviation,
                std::vector<Vec3f>& broad, const Work& work) {
  constexpr float kSame = 2, kSharp = 3;  // local deviation / the phase's: grain alone, and an edge
  constexpr float kLeastZone = 0.2f, kMostZone = 0.8f;  // shares of the pixels around, where there is an edge
  constexpr float kBetween = 3;                         // of the phase's deviations, off every zone
  constexpr std::size_t kEnough = 4000;                 // used pixels of a phase
  const auto all = [](std::size_t) { return true; };
  const std::size_t n = broad.size();
  std::vector<Vec3f> soft = p.offset, square(n, Vec3f::Zero()), spread(n, Vec3f::Zero());
  for (std::size_t i = 0; i < n; ++i)
    if (const auto k = p.phase[i]; k >= 0)
      square[i].setConstant(((p.offset[i] - broad[i]).array() / deviation[k].array()).square().sum());
  blur_labels(p, labels, kBroad, square, all, spread, work);
  blur_labels(p, labels, 1, p.offset, all, soft, work);
  const std::vector<float> weight = weights_around_edge();
  std::vector<Vec3f> out = broad;
  std::vector<std::uint8_t> between(n, 0);
  work.quiet().parallel(
      static_cast<std::size_t>(p.height) * p.sections, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row)
          for (int x = 0; x < p.width; ++x) {
            const std::size_t i = row * p.width + x;
            if (p.phase[i] < 0) continue;
            const float local = std::sqrt(spread[i].x() / 3);
            if (local <= kSame) continue;
            const Vec3f& d = deviation[p.phase[i]];
            const EdgeZone zone = zone_at(p, labels, soft, weight, d, row, x);
            if (zone.share < kLeastZone) continue;
            const float part = std::min(1.0f, (local - kSame) / (kSharp - kSame));
            out[i] = (1 - part) * broad[i] + part * zone.mean;
            between[i] = zone.share < kMostZone &&
                         ((p.offset[i] - zone.mean).cwiseAbs().array() > kBetween * d.array()).any();
          }
      });
  broad = std::move(out);
  std::vector<std::size_t> left = p.pixels;
  for (std::size_t i = 0; i < n; ++i)
    if (between[i]) --left[p.phase[i]];
  for (std::size_t i = 0; i < n; ++i)
    if (between[i] && left[p.phase[i]] >= kEnough) {
      --p.pixels[p.phase[i]];
      p.phase[i] = -1;
    }
}

void smooth(std::vector<float>& v, int n, double sigma, const Work& work) {
  const int reach = std::min(round_up(3 * sigma), 4 * n);
  std::vector<float> kernel(n, 0.0f);  // wrapped around the tile
  for (int t = -reach; t <= reach; ++t)
    kernel[wrap_index(t, n)] += static_cast<float>(std::exp(-0.5 * t * t / (sigma * sigma)));
  double squares = 0;
  for (const float k : kernel) squares += static_cast<double>(k) * k;
  for (float& k : kernel) k = k / std::sqrt(squares);  // keeps the variance of white noise
  const std::size_t step[3] = {1, static_cast<std::size_t>(n), static_cast<std::size_t>(n) * n};
  for (int a = 0; a < 3; ++a) {
    const int b = a == 0 ? 1 : 0, c = a == 2 ? 1 : 2;
    work.quiet().parallel(n, 2, [&](std::size_t begin, std::size_t end) {
      std::vector<float> line(2 * n), out(static_cast<std::size_t>(n));
      for (std::size_t j = begin; j < end; ++j)
        for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
          float* first = &v[j * step[c] + i * step[b]];
          for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k)
            line[k] = line[k + n] = first[k * step[a]];
          for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) {
            float s = 0;
            for (std::size_t t = 0; t < static_cast<std::size_t>(n); ++t) s += kernel[t] * line[k + t];
            out[k] = s;
          }
          for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) first[k * step[a]] = out[k];
        }
    });
  }
}

}  // namespace

std::vector<Vec3f> split_broad(Phases& phases, const Labels& labels, const Work& work) {
  constexpr float kSpeck = 4;    // robust standard deviations
  constexpr float kZone = 0.2f;  // share of the pixels around that are as far off in a zone or shadow
  const auto all = [](std::size_t) { return true; };
  std::vector<Vec3f> broad(phases.offset.size(), Vec3f::Zero()), far = broad, around = broad;
  blur_labels(phases, labels, kBroad, phases.offset, all, broad, work);
  // Specks, pits and cracks belong to the fine part as a whole. If they counted here, the fine part would
  // have a halo around each, and what lies between them would take their mean color.
  const std::vector<Vec3f> deviation = deviations(phases, broad);
  for (std::size_t i = 0; i < far.size(); ++i)
    if (const auto k = phases.phase[i]; k >= 0)
      far[i].setConstant(
          ((phases.offset[i] - broad[i]).cwiseAbs().array() > kSpeck * deviation[k].array()).any());
  blur_labels(phases, labels, kBroad, far, all, around, work);
  blur_labels(
      phases, labels, kBroad, phases.offset,
      [&](std::size_t i) { return far[i].x() == 0 || around[i].x() > kZone; }, broad, work);
  keep_edges(phases, labels, deviation, broad, work);
  std::vector<Mean> mean(phases.pixels.size());
  for (std::size_t i = 0; i < broad.size(); ++i)
    if (const auto k = phases.phase[i]; k >= 0) mean[k].add(broad[i]);
  for (std::size_t i = 0; i < broad.size(); ++i)
    if (const auto k = phases.phase[i]; k >= 0) {
      broad[i] -= mean[k].value();
      phases.offset[i] -= broad[i];
    }
  return broad;
}

Eigen::VectorXd nonnegative_fit(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::MatrixXd gram = A.transpose() * A;
  const Eigen::VectorXd right = A.transpose() * b;
  Eigen::VectorXd w = Eigen::VectorXd::Zero(A.cols());
  for (int round = 0; round < 2000; ++round)
    for (Eigen::Index k = 0; k < w.size(); ++k)
      if (gram(k, k) > 0) w[k] = std::max(0.0, w[k] + (right[k] - gram.row(k).dot(w)) / gram(k, k));
  return w;
}

BroadModel fit_broad(const std::vector<Vec3f>& broad, const Phases& p, const Labels& labels, int phase,
                     std::uint64_t seed) {
  BroadModel model;
  model.sigma.assign(kSigmas.begin(), kSigmas.end());
  model.variance.assign(kSigmas.size(), Vec3::Zero());
  std::vector<std::size_t> used;
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] == phase) {
      used.push_back(i);
      mean += broad[i].cast<double>();
    }
  if (used.size() < 256) return model;
  mean /= static_cast<double>(used.size());
  Mat3 covariance = Mat3::Zero();
  for (const std::size_t i : used) {
    const Vec3 d = broad[i].cast<double>() - mean;
    covariance += d * d.transpose();
  }
  model.axes = eigen_axes(covariance).eigenvectors();
  std::vector<Vec3> sum(kReach, Vec3::Zero());
  std::vector<double> count(kReach, 0.0);
  Random random(seed, 0x62726f61);
  for (int n = 0; n < kPairs; ++n) {
    const std::size_t i = used[random.below(used.size())];
    const double r = random.uniform(0, kReach), angle = random.uniform(0, 2 * M_PI);
    const int in = i % p.plane();
    const int x = in % p.width + round_nearest(r * std::cos(angle)),
              y = in / p.width + round_nearest(r * std::sin(angle));
    if (x < 0 || y < 0 || x >= p.width || y >= p.height) continue;
    const std::size_t j = i - static_cast<std::size_t>(in) + pixel_at(x, y, p.width);
    if (p.phase[j] != phase || labels.ids[j] != labels.ids[i]) continue;
    const Vec3 a = model.axes.transpose() * (broad[i].cast<double>() - mean),
               b = model.axes.transpose() * (broad[j].cast<double>() - mean);
    const std::size_t bin = r;
    sum[bin] += a.cwiseProduct(b);
    ++count[bin];
  }
  // Pairs far apart are few in small particles; each distance weighs by its number of pairs.
  Eigen::MatrixXd A(kReach, kSigmas.size());
  Eigen::MatrixXd b(kReach, 3);
  for (int r = 0; r < kReach; ++r) {
    const double weight = std::sqrt(count[r]);
    for (std::size_t k = 0; k < kSigmas.size(); ++k)
      A(r, k) = weight * std::exp(-(r + 0.5) * (r + 0.5) / (4 * kSigmas[k] * kSigmas[k]));
    b.row(r) = (sum[r] / std::max(count[r], 1.0) * weight).transpose();
  }
  for (int c = 0; c < 3; ++c) {
    const Eigen::VectorXd w = nonnegative_fit(A, b.col(c));
    for (std::size_t k = 0; k < kSigmas.size(); ++k) model.variance[k][c] = w[k];
  }
  return model;
}

std::vector<Vec3f> broad_field(const BroadModel& model, int size, std::uint64_t seed, const Work& work) {
  std::vector<Vec3f> out(static_cast<std::size_t>(size) * size * size, Vec3f::Zero());
  const Eigen::Matrix3f axes = model.axes.cast<float>();
  for (std::size_t k = 0; k < model.sigma.size(); ++k)
    for (int c = 0; c < 3; ++c) {
      if (!(model.variance[k][c] > 1e-9)) continue;
      work.check();
      std::vector<float> noise(out.size());
      work.quiet().parallel(noise.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) noise[i] = Random(seed, 0x100 + k * 3 + c, i).normal();
      });
      smooth(noise, size, model.sigma[k], work);
      double mean = 0;
      for (const float v : noise) mean += v;
      mean /= noise.size();
      for (float& v : noise) v -= static_cast<float>(mean);
      const Vec3f direction = axes.col(c) * static_cast<float>(std::sqrt(model.variance[k][c]));
      for (std::size_t i = 0; i < out.size(); ++i) out[i] += noise[i] * direction;
    }
  return out;
}

}  // namespace terrazzo::detail_solid
