#include "nodes/bodies/view/exposure.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "nodes/common/geometry/rank.h"
#include "nodes/data/indices.h"
#include "nodes/data/luminance.h"

namespace terrazzo::view {
namespace {

constexpr float kDarkest = 1e-6F;

// Pixels of the stones that are large enough to be judged, stone by stone; evenly chosen if there are many.
struct StoneSamples {
  std::vector<std::size_t> pixels;
  std::vector<std::size_t> first;  // of each stone, and the end
  std::size_t step = 1;            // of the chosen pixels

  explicit StoneSamples(const UnlitPixels& p) {
    constexpr std::size_t kMost = 200'000;
    constexpr std::size_t kFewest = 30;  // samples of a stone
    const auto counts = [&](std::size_t i) { return p.lit_stone(i); };
    std::size_t all = 0;
    std::int32_t last = -1;
    for (std::size_t i = 0; i < p.stone.size(); ++i) {
      if (!counts(i)) continue;
      ++all;
      last = std::max(last, p.stone[i]);
    }
    step = 1 + all / kMost;
    std::vector<std::vector<std::size_t>> of_stone(last + 1);
    std::size_t seen = 0;
    for (std::size_t i = 0; i < p.stone.size(); ++i)
      if (counts(i) && seen++ % step == 0) of_stone[p.stone[i]].push_back(i);
    first.push_back(0);
    for (const std::vector<std::size_t>& own : of_stone) {
      if (own.size() < kFewest) continue;
      pixels.insert(pixels.end(), own.begin(), own.end());
      first.push_back(pixels.size());
    }
  }
};

// Hidden parts of the sky return light that was reflected any number of times (Stewart and Langer 1997: what
// they see is as bright as the place itself).
float light_of_pixel(const UnlitPixels& p, std::size_t i, float share) {
  return share * p.sun[i] + (1 - share) * p.sky[i] / (1 - p.albedo * (1 - p.sky[i]));
}

// Light with shadows that are deeper by a power, or lighter below 1.
float shadowed(float light, float power) { return light < 1 ? std::pow(light, power) : light; }

// How fast the logarithm of luminance grows towards the light across a stone, per radius: Profiles::light, in
// the direction `towards`.
class SlopesOfStones {
 public:
  SlopesOfStones(const UnlitPixels& p, const StoneSamples& samples, const Vec2& towards)
      : p_(p), samples_(samples) {
    for (std::size_t s = 0; s + 1 < samples.first.size(); ++s) add_stone(s, towards);
  }

  // As Segment measures it, with a share of the sun and shadows that are deeper by a power.
  double median_with(float share, float power) const {
    std::vector<float> light;
    for (const std::size_t i : samples_.pixels) light.push_back(light_of_pixel(p_, i, share));
    const float usual = std::max(kDarkest, median(light));
    for (std::size_t k = 0; k < light.size(); ++k)
      light[k] = luminance_of(p_.color[samples_.pixels[k]]) * shadowed(light[k] / usual, power);
    std::vector<float> sorted = light;
    const float dark = 0.02F * at_rank(sorted, sorted.size() * 9 / 10) + kDarkest;
    std::vector<double> slopes;
    for (std::size_t s = 0; s + 1 < samples_.first.size(); ++s) {
      double slope = 0;
      for (std::size_t k = samples_.first[s]; k < samples_.first[s + 1]; ++k)
        slope += weight_[k] * std::log(dark + light[k]);
      slopes.push_back(slope);
    }
    return median(std::move(slopes));
  }

 private:
  // The slope of the plane through values by least squares is a weighted sum of them.
  void add_stone(std::size_t s, const Vec2& towards) {
    const std::size_t first = samples_.first[s];
    const std::size_t end = samples_.first[s + 1];
    const double radius = std::sqrt(samples_.step * (end - first) / std::numbers::pi);
    const auto place = [&](std::size_t k) {
      const auto at = Vec2(samples_.pixels[k] % p_.width, -double(samples_.pixels[k] / p_.width));
      return Vec2(at / radius);
    };
    Vec2 mean = Vec2::Zero();
    for (std::size_t k = first; k < end; ++k) mean += place(k) / (end - first);
    Eigen::Matrix2d squares = Eigen::Matrix2d::Identity() * 1e-9;
    for (std::size_t k = first; k < end; ++k) squares += (place(k) - mean) * (place(k) - mean).transpose();
    const Vec2 across = squares.inverse() * towards;
    for (std::size_t k = first; k < end; ++k) weight_.push_back(across.dot(place(k) - mean));
  }

  const UnlitPixels& p_;
  const StoneSamples& samples_;
  std::vector<double> weight_;  // of each sample
};

// More sun makes slopes steeper. Between an overcast sky and a clear one.
float sun_share(const SlopesOfStones& slopes, double wanted, float power, const Work& work) {
  constexpr int kHalvings = 7;
  float low = 0.05F;
  float high = 0.85F;
  for (int k = 0; k < kHalvings; ++k) {
    work.check();
    const float middle = (low + high) / 2;
    (slopes.median_with(middle, power) > wanted ? high : low) = middle;
  }
  return (low + high) / 2;
}

// The power of the light in shadows at which the darkest pixels are as much darker than the middle ones as in
// the photograph, whose sky and reflected light sixteen rays don't know. `own`: a factor of each color.
float depth_of_shadows(const UnlitPixels& p, const std::vector<float>& light, const std::vector<float>& own,
                       const std::vector<float>& tones, const Work& work) {
  constexpr std::size_t kSamples = 200'000;
  constexpr int kHalvings = 10;
  constexpr double kDark = 0.05;  // share of pixels
  const auto contrast_of = [&](std::vector<float> luminances) {
    const float dark = at_rank(luminances, luminances.size() * kDark);
    return std::log((kDarkest + median(std::move(luminances))) / (kDarkest + dark));
  };
  const float wanted = contrast_of(tones);
  const auto contrast = [&](float power) {
    work.check();
    std::vector<float> luminances;
    for (std::size_t i = 0; i < light.size(); i += 1 + light.size() / kSamples)
      luminances.push_back(own[i] * luminance_of(p.color[i]) * shadowed(light[i], power));
    return contrast_of(std::move(luminances));
  };
  float low = 0.4F;
  float high = 2;
  for (int k = 0; k < kHalvings; ++k) {
    const float middle = (low + high) / 2;
    (contrast(middle) < wanted ? low : high) = middle;
  }
  return (low + high) / 2;
}

// Divides light by the usual one, on stones and on soil.
void use_usual_light(const UnlitPixels& p, std::vector<float>& light) {
  std::vector<float> on_stones;
  double on_soil = 0;
  std::size_t soil_pixels = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (p.stone[i] < 0) {
      on_soil += light[i];
      ++soil_pixels;
    } else if (p.height[i] > p.ground) {
      on_stones.push_back(light[i]);
    }
  }
  const float stone_light = on_stones.empty() ? 1 : std::max(kDarkest, median(std::move(on_stones)));
  const float soil_light =
      soil_pixels == 0 ? 1 : std::max(kDarkest, static_cast<float>(on_soil / soil_pixels));
  for (std::size_t i = 0; i < light.size(); ++i) light[i] /= p.stone[i] < 0 ? soil_light : stone_light;
}

// The factor that makes stones as bright as in the photograph: the mean by area of the medians of stones.
float brightness_for(const UnlitPixels& p, const std::vector<float>& light, const StoneSamples& samples,
                     float wanted) {
  double sum = 0;
  std::vector<float> own;
  for (std::size_t s = 0; s + 1 < samples.first.size(); ++s) {
    own.clear();
    for (std::size_t k = samples.first[s]; k < samples.first[s + 1]; ++k)
      own.push_back(light[samples.pixels[k]] * p.color[samples.pixels[k]].mean());
    sum += double(own.size()) * at_rank(own, own.size() / 2);
  }
  return sum > 0 ? static_cast<float>(wanted * samples.pixels.size() / sum) : 1;
}

// Sums over the visible part of a stone.
struct StoneSums {
  double pixels = 0, color = 0, light = 0;  // of pixels, and of logarithms

  void add(const StoneSums& other) {
    pixels += other.pixels;
    color += other.color;
    light += other.light;
  }
  void divide() {
    color /= std::max(1.0, pixels);
    light /= std::max(1.0, pixels);
  }
};

// How far apart the quartiles by area are of `share` · color + `light` · light.
double spread_of(const std::vector<StoneSums>& stones, double share, double light) {
  std::vector<std::pair<double, double>> values;  // and pixels
  double pixels = 0;
  for (const StoneSums& s : stones) {
    values.emplace_back(share * s.color + light * s.light, s.pixels);
    pixels += s.pixels;
  }
  std::sort(values.begin(), values.end());
  double below = 0, lower = 0;
  for (const auto& [value, own] : values) {
    if (below < pixels / 4) lower = value;
    below += own;
    if (below >= 0.75 * pixels) return value - lower;
  }
  return 0;
}

// The share of a stone's difference in color that, with its light, differs as much as colors alone. Quartiles
// tell, because nobody can outline the darkest stones in a photograph.
double share_of_colors(const std::vector<StoneSums>& stones, const Work& work) {
  constexpr int kHalvings = 10;
  const double wanted = spread_of(stones, 1, 0);
  double low = 0, high = 1;
  for (int k = 0; k < kHalvings; ++k) {
    work.check();
    const double middle = (low + high) / 2;
    (spread_of(stones, middle, 1) > wanted ? high : low) = middle;
  }
  return high;
}

// The light that a photograph shows on its stones is part of the colors that were measured there, and falls
// on them again in the bed. So colors keep only the part with which stones differ as in the photograph: the
// factor of each pixel's color.
std::vector<float> without_photographed_light(const UnlitPixels& p, const std::vector<float>& light,
                                              float power, const Work& work) {
  std::vector<StoneSums> stones;
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (!p.lit_stone(i)) continue;
    if (stones.size() <= static_cast<std::size_t>(p.stone[i])) stones.resize(p.stone[i] + 1);
    stones[p.stone[i]].add(
        {1, std::log(kDarkest + luminance_of(p.color[i])), std::log(kDarkest + shadowed(light[i], power))});
  }
  std::vector<StoneSums> shown;
  double mean = 0, pixels = 0;  // of colors
  for (StoneSums& s : stones) {
    const double color = s.color;
    s.divide();
    if (!(s.pixels > 0) || !std::isfinite(s.color) || !std::isfinite(s.light)) continue;
    shown.push_back(s);
    mean += color;
    pixels += s.pixels;
  }
  std::vector<float> own(light.size(), 1);
  if (shown.empty()) return own;
  mean /= pixels;
  const double less = share_of_colors(shown, work) - 1;
  for (std::size_t i = 0; i < light.size(); ++i)
    if (p.lit_stone(i)) own[i] = static_cast<float>(std::exp(less * (stones[p.stone[i]].color - mean)));
  return own;
}

}  // namespace

std::vector<float> exposure(const UnlitPixels& p, const SurfaceOptions& options, const Work& work) {
  const bool matched = options.loose && !options.tones.empty();
  const int rounds = matched ? 3 : 1;  // slopes, shadows and colors depend on each other
  const StoneSamples samples(p);
  std::optional<SlopesOfStones> slopes;
  if (options.slope && !samples.pixels.empty()) slopes.emplace(p, samples, options.slope->normalized());
  float share = static_cast<float>(options.light.share);
  float power = 1;
  std::vector<float> light(p.stone.size());
  std::vector<float> own(p.stone.size(), 1);
  for (int round = 0; round < rounds; ++round) {
    work.check();
    if (slopes) share = sun_share(*slopes, options.slope->norm(), power, work);
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = light_of_pixel(p, i, share);
    use_usual_light(p, light);
    if (options.brightness) own = without_photographed_light(p, light, power, work);
    if (matched) power = depth_of_shadows(p, light, own, options.tones, work);
  }
  for (std::size_t i = 0; i < light.size(); ++i) light[i] = own[i] * shadowed(light[i], power);
  const float brightness = options.brightness ? brightness_for(p, light, samples, *options.brightness) : 1;
  for (std::size_t i = 0; i < light.size(); ++i)  // soil is as measured
    if (options.loose || p.lit_stone(i)) light[i] *= brightness;
  return light;
}

}  // namespace terrazzo::view
