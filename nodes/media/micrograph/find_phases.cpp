#include "nodes/media/micrograph/find_phases.h"

#include <fmt/format.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "nodes/media/micrograph/gray_peaks.h"
#include "nodes/media/micrograph/gray_picture.h"
#include "nodes/media/micrograph/phase_field.h"

namespace terrazzo::media {
namespace {

constexpr int kRounds = 10;       // of labels, levels and light in turn
constexpr double kSamples = 1e6;  // pixels that the light is fitted to
constexpr int kTerms = 6;         // of the quadratic polynomial that describes the light

using Terms = Eigen::Matrix<double, kTerms, 1>;

Terms terms_at(const GrayPicture& p, int x, int y) {
  const double u = 2.0 * x / p.width - 1, v = 2.0 * y / p.height - 1;
  return {1, u, v, u * u, u * v, v * v};
}

// The light that explains best what `level` leaves of each pixel, without its mean. `level` may be one number
// for all pixels.
template <class LevelOf>
void fit_light(GrayPicture& p, LevelOf&& level) {
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

// The nearest level to the mean of 3 × 3 pixels, which single noisy pixels do not change.
std::vector<std::uint8_t> nearest_levels(const GrayPicture& p, const std::vector<double>& level) {
  cv::Mat1f flat = p.gray - p.light;
  cv::GaussianBlur(flat, flat, {3, 3}, 0, 0, cv::BORDER_REPLICATE);
  std::vector<std::uint8_t> out;
  for (const float g : flat) {
    std::uint8_t best = 0;
    for (std::size_t k = 1; k < level.size(); ++k)
      if (std::abs(g - level[k]) < std::abs(g - level[best])) best = static_cast<std::uint8_t>(k);
    out.push_back(best);
  }
  return out;
}

// How well each phase explains the gray level of a pixel: −ln of a normal density.
Costs cost_of(const GrayPicture& p, const PhaseLevels& levels, int x, int y) {
  Costs out{};
  if (!p.observed(x, y)) return out;
  const float g = p.at(x, y);
  for (std::size_t k = 0; k < levels.level.size(); ++k) {
    const double d = (g - levels.level[k]) / levels.noise[k];
    out[k] = d * d / 2 + std::log(levels.noise[k]);
  }
  return out;
}

// Without phases if the histogram has a single peak. The light of the picture is where it starts.
FoundPhases from_start(const Image& image, GrayPicture& picture, const PhaseOptions& options,
                       const Work& work) {
  const cv::Mat1f flat = picture.gray - picture.light;
  PhaseLevels levels{gray_levels(flat, picture.in, options.phases), {}};
  if (levels.level.size() < 2) return {};
  levels.noise.assign(levels.level.size(), 1);
  PhaseField field{picture.width, picture.height, count_of(levels.level), options.smoothing,
                   nearest_levels(picture, levels.level)};
  const auto cost = [&](int x, int y) { return cost_of(picture, levels, x, y); };
  measure(picture, field.label, levels);
  for (int round = 0; round < kRounds; ++round) {
    field.decide(cost, work);
    if (options.shading)
      fit_light(picture,
                [&](int x, int y) { return levels.level[field.label[pixel_at(x, y, picture.width)]]; });
    measure(picture, field.label, levels);
    work.done(round + 1, kRounds);
  }
  FoundPhases out = summary(image, picture, field.label, levels);
  out.uncertain = field.uncertain(picture.in, cost);
  return out;
}

}  // namespace

double phases_forecast(const Image& image) { return 90.0 * pixels_in(image.width, image.height); }

FoundPhases find_phases(const Image& image, const std::vector<std::uint8_t>& unobserved,
                        const PhaseOptions& options, const Work& work) {
  GrayPicture picture = gray_picture(image, unobserved);
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
