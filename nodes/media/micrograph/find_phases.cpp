#include "nodes/media/micrograph/find_phases.h"

#include <fmt/format.h>
#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/media/micrograph/gray_peaks.h"

namespace terrazzo::media {
namespace {

constexpr int kRounds = 10;            // of labels, levels and light in turn
constexpr double kLeastNoise = 0.002;  // half a step of 8 bits
constexpr double kSure = 0.9;
constexpr double kSamples = 1e6;  // pixels that the light is fitted to
constexpr int kTerms = 6;         // of the quadratic polynomial that describes the light

struct Picture {
  int width = 0, height = 0;
  cv::Mat1f gray;                // along the main axis of display-encoded colors
  cv::Mat1f light;               // slow changes of it
  std::vector<std::uint8_t> in;  // 1 for observed pixels
  bool observed(int x, int y) const { return in[pixel_at(x, y, width)] != 0; }
  float at(int x, int y) const { return gray(y, x) - light(y, x); }
};

// The direction in which colors differ most, towards light.
Vec3 main_axis(const std::vector<Vec3f>& color, const std::vector<std::uint8_t>& in) {
  Vec3 mean = Vec3::Zero();
  double n = 0;
  for (std::size_t i = 0; i < color.size(); ++i)
    if (in[i]) {
      mean += color[i].cast<double>();
      ++n;
    }
  mean /= n;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < color.size(); ++i)
    if (in[i]) {
      const Vec3 d = color[i].cast<double>() - mean;
      covariance += d * d.transpose();
    }
  Vec3 axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(2);
  if (axis.sum() < 0) axis = -axis;
  return axis;
}

Picture picture_of(const Image& image, const std::vector<std::uint8_t>& unobserved) {
  Picture out{image.width, image.height, cv::Mat1f(image.height, image.width), {}, {}};
  const std::size_t n = pixels_in(image.width, image.height);
  if (n == 0) throw Error("empty-image", "the image has no pixels", "connect an image");
  out.in.assign(n, 1);
  std::vector<Vec3f> color(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!unobserved.empty() && unobserved[i]) out.in[i] = 0;
    if (!image.pixels[i].allFinite())
      throw Error("bad-pixels",
                  fmt::format("a color is NaN or infinite at ({}, {})", i % image.width, i / image.width),
                  "replace the bad pixels in the picture");
    color[i] = linear_to_srgb(image.pixels[i]);
  }
  if (std::count(out.in.begin(), out.in.end(), 1) == 0)
    throw Error("empty-image", "no pixel of the image is observed", "connect a smaller mask");
  const Vec3f axis = main_axis(color, out.in).cast<float>();
  for (std::size_t i = 0; i < n; ++i) out.gray.ptr<float>()[i] = axis.dot(color[i]);
  out.light = cv::Mat1f::zeros(image.height, image.width);
  return out;
}

using Terms = Eigen::Matrix<double, kTerms, 1>;

Terms terms_at(const Picture& p, int x, int y) {
  const double u = 2.0 * x / p.width - 1, v = 2.0 * y / p.height - 1;
  return {1, u, v, u * u, u * v, v * v};
}

// The light that explains best what `level` leaves of each pixel, without its mean. `level` may be one number
// for all pixels.
template <class LevelOf>
void fit_light(Picture& p, LevelOf&& level) {
  Eigen::Matrix<double, kTerms, kTerms> matrix = decltype(matrix)::Zero();
  Terms right = Terms::Zero(), sum = Terms::Zero();
  double n = 0;
  const int step = std::max(1, static_cast<int>(std::sqrt(p.in.size() / kSamples)));
  for (int y = 0; y < p.height; y += step)
    for (int x = 0; x < p.width; x += step)
      if (p.observed(x, y)) {
        const Terms t = terms_at(p, x, y);
        matrix += t * t.transpose();
        right += t * (p.gray(y, x) - level(x, y));
        sum += t;
        ++n;
      }
  Terms solution = matrix.ldlt().solve(right);
  solution[0] -= solution.dot(sum) / n;
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) p.light(y, x) = static_cast<float>(solution.dot(terms_at(p, x, y)));
}

class Field {
 public:
  Field(Picture& picture, std::vector<double> levels, double smoothing)
      : p_(picture), level_(std::move(levels)), smoothing_(smoothing), noise_(level_.size(), 1) {
    start();
    measure();
  }

  // The most probable phase of each pixel, given its neighbors (Besag 1986), in four sets of pixels that do
  // not touch.
  void decide(const Work& work) {
    for (int set = 0; set < 4; ++set) {
      const int rows = (p_.height - (set / 2) + 1) / 2;
      work.quiet().parallel(rows, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j)
          for (int y = 2 * static_cast<int>(j) + set / 2, x = set % 2; x < p_.width; x += 2) {
            const auto e = energies(x, y);
            label_[pixel_at(x, y, p_.width)] =
                static_cast<std::uint8_t>(std::min_element(e.begin(), e.begin() + phases()) - e.begin());
          }
      });
    }
  }

  // Levels and noise from the labels.
  void measure() {
    std::vector<double> sum(phases(), 0), squares(phases(), 0), n(phases(), 0);
    each_observed([&](int x, int y, std::uint8_t label) {
      const double g = p_.at(x, y);
      sum[label] += g;
      squares[label] += g * g;
      ++n[label];
    });
    for (int k = 0; k < phases(); ++k) {
      if (n[k] == 0) continue;  // keeps its level
      level_[k] = sum[k] / n[k];
      noise_[k] = std::max(kLeastNoise, std::sqrt(std::max(0.0, squares[k] / n[k] - level_[k] * level_[k])));
    }
  }

  void light() {
    fit_light(p_, [&](int x, int y) { return level_[label_[pixel_at(x, y, p_.width)]]; });
  }

  double uncertain() const {
    double unsure = 0, n = 0;
    each_observed([&](int x, int y, std::uint8_t label) {
      const auto e = energies(x, y);
      double all = 0;
      for (int k = 0; k < phases(); ++k) all += std::exp(e[label] - e[k]);
      unsure += 1 / all < kSure;
      ++n;
    });
    return unsure / n;
  }

  template <class Use>
  void each_observed(Use&& use) const {
    for (int y = 0; y < p_.height; ++y)
      for (int x = 0; x < p_.width; ++x)
        if (p_.observed(x, y)) use(x, y, label_[pixel_at(x, y, p_.width)]);
  }
  int phases() const { return count_of(level_); }
  const std::vector<double>& level() const { return level_; }
  const std::vector<double>& noise() const { return noise_; }
  const std::vector<std::uint8_t>& labels() const { return label_; }

 private:
  // The nearest level to the mean of 3 × 3 pixels, which single noisy pixels do not change.
  void start() {
    cv::Mat1f flat = p_.gray - p_.light;
    cv::GaussianBlur(flat, flat, {3, 3}, 0, 0, cv::BORDER_REPLICATE);
    for (const float g : flat) {
      int best = 0;
      for (int k = 1; k < phases(); ++k)
        if (std::abs(g - level_[k]) < std::abs(g - level_[best])) best = k;
      label_.push_back(best);
    }
  }

  // −ln of the probability of each phase at a pixel, up to a constant.
  std::array<double, kMostPhases> energies(int x, int y) const {
    std::array<double, kMostPhases> out{};
    const float g = p_.at(x, y);
    for (int k = 0; k < phases(); ++k) {
      const double d = (g - level_[k]) / noise_[k];
      out[k] = p_.observed(x, y) ? d * d / 2 + std::log(noise_[k]) : 0;
    }
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int u = x + dx, v = y + dy;
        if ((dx == 0 && dy == 0) || u < 0 || v < 0 || u >= p_.width || v >= p_.height) continue;
        out[label_[pixel_at(u, v, p_.width)]] -= smoothing_ * (dx != 0 && dy != 0 ? std::sqrt(0.5) : 1);
      }
    return out;
  }

  Picture& p_;
  std::vector<double> level_;
  double smoothing_;
  std::vector<double> noise_;
  std::vector<std::uint8_t> label_;
};

void summarize(const Image& image, const Picture& p, const Field& field, FoundPhases& out) {
  const int phases = field.phases();
  out.level = field.level();
  out.noise = field.noise();
  out.color.assign(phases, Vec3f::Zero());
  std::vector<double> n(phases, 0);
  field.each_observed([&](int x, int y, std::uint8_t label) {
    out.color[label] += image.at(x, y);
    ++n[label];
  });
  for (int k = 0; k < phases; ++k)
    if (n[k] > 0) out.color[k] /= static_cast<float>(n[k]);
  out.separation = 1e300;
  for (int k = 1; k < phases; ++k)
    out.separation =
        std::min(out.separation, (out.level[k] - out.level[k - 1]) / (out.noise[k] + out.noise[k - 1]));
  double low = 0, high = 0;
  cv::minMaxLoc(p.light, &low, &high);
  out.shading = high - low;
  out.uncertain = field.uncertain();
  out.map = {p.width, p.height, phases, image.pixel_size, field.labels()};
  for (std::size_t i = 0; i < out.map.at.size(); ++i)
    if (!p.in[i]) out.map.at[i] = kUnobserved;
}

// Without phases if the histogram has a single peak. The light of the picture is where it starts.
FoundPhases from_start(const Image& image, Picture& picture, const PhaseOptions& options, const Work& work) {
  FoundPhases out;
  const cv::Mat1f flat = picture.gray - picture.light;
  const auto levels = gray_levels(flat, picture.in, options.phases);
  if (levels.size() < 2) return out;
  Field field(picture, levels, options.smoothing);
  for (int round = 0; round < kRounds; ++round) {
    field.decide(work);
    if (options.shading) field.light();
    field.measure();
    work.done(round + 1, kRounds);
  }
  summarize(image, picture, field, out);
  return out;
}

}  // namespace

double phases_forecast(const Image& image) { return 90.0 * pixels_in(image.width, image.height); }

FoundPhases find_phases(const Image& image, const std::vector<std::uint8_t>& unobserved,
                        const PhaseOptions& options, const Work& work) {
  Picture picture = picture_of(image, unobserved);
  FoundPhases even = from_start(image, picture, options, work.part(0, options.shading ? 0.5 : 1));
  FoundPhases uneven;
  // Light that varies much hides the phases from the start. If the picture's own slow changes are taken for
  // light, large structures fade. The better start separates the phases better.
  if (options.shading) {
    fit_light(picture, [](int, int) { return 0.0; });
    uneven = from_start(image, picture, options, work.part(0.5, 1));
  }
  if (even.map.phases == 0 && uneven.map.phases == 0)
    throw Error(
        "one-phase", "the gray levels have a single peak, so phases cannot be distinguished",
        "set phases of Phases, or use a picture with more contrast between the phases and less noise");
  return even.map.phases > 0 && even.separation >= uneven.separation ? even : uneven;
}

}  // namespace terrazzo::media
