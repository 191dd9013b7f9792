#include "nodes/bodies/view/exposure.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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

  explicit StoneSamples(const UnlitPixels& p) {
    constexpr std::size_t kMost = 200'000;
    constexpr std::size_t kFewest = 30;  // pixels of a stone
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < p.stone.size(); ++i)
      if (p.stone[i] >= 0 && p.height[i] > p.ground) all.push_back(i);
    std::stable_sort(all.begin(), all.end(),
                     [&](std::size_t a, std::size_t b) { return p.stone[a] < p.stone[b]; });
    const std::size_t step = 1 + all.size() / kMost;
    first.push_back(0);
    for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
      while (end < all.size() && p.stone[all[end]] == p.stone[all[begin]]) ++end;
      if (end - begin < kFewest) continue;
      for (std::size_t k = begin; k < end; k += step) pixels.push_back(all[k]);
      first.push_back(pixels.size());
    }
  }
};

// The value of each sampled pixel and the median of its stone's.
struct SampledValues {
  std::vector<float> value, median;
};

template <class Value>
SampledValues sampled(const StoneSamples& samples, const Value& value) {
  SampledValues out;
  out.value.reserve(samples.pixels.size());
  for (const std::size_t i : samples.pixels) out.value.push_back(value(i));
  std::vector<float> own;
  for (std::size_t s = 0; s + 1 < samples.first.size(); ++s) {
    own.assign(out.value.begin() + samples.first[s], out.value.begin() + samples.first[s + 1]);
    const float middle = at_rank(own, own.size() / 2);
    out.median.insert(out.median.end(), own.size(), middle);
  }
  return out;
}

float light_of_pixel(const UnlitPixels& p, std::size_t i, float share) {
  return share * p.sun[i] + (1 - share) * p.sky[i] + p.bounce * (1 - p.sky[i]);
}

// As Profiles::shading.
float shading_with(const UnlitPixels& p, const StoneSamples& samples, float share) {
  const SampledValues v = sampled(samples, [&](std::size_t i) {
    return std::log(kDarkest + luminance_of(p.color[i]) * light_of_pixel(p, i, share));
  });
  std::vector<float> off;
  for (std::size_t k = 0; k < v.value.size(); ++k) off.push_back(std::abs(v.value[k] - v.median[k]));
  return off.empty() ? 0 : median(std::move(off));
}

// More sun makes stones more uneven. Between an overcast sky and a clear one.
float sun_share(const UnlitPixels& p, const StoneSamples& samples, double wanted) {
  constexpr int kHalvings = 7;
  float low = 0.05F;
  float high = 0.85F;
  for (int k = 0; k < kHalvings; ++k) {
    const float middle = (low + high) / 2;
    (shading_with(p, samples, middle) > wanted ? high : low) = middle;
  }
  return (low + high) / 2;
}

// Light with shadows that are deeper by a power.
float shadowed(float light, float power) { return light < 1 ? std::pow(light, power) : light; }

// The power of the light in shadows at which the places between loose stones are as dark, on average, as in
// the photograph, whose binder they are. Light that is reflected often has a color and a strength that
// sixteen rays don't know.
float depth_of_shadows(const UnlitPixels& p, const std::vector<float>& light) {
  constexpr float kMost = 2;
  constexpr int kHalvings = 12;
  const float wanted = p.between.mean();
  const auto darkness = [&](float power) {
    double sum = 0;
    std::size_t pixels = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
      if (p.height[i] > p.ground) continue;
      sum += p.color[i].mean() * shadowed(light[i], power);
      ++pixels;
    }
    return pixels == 0 ? wanted : static_cast<float>(sum / pixels);
  };
  if (darkness(1) <= wanted) return 1;
  float low = 1;
  float high = kMost;
  for (int k = 0; k < kHalvings; ++k) {
    const float middle = (low + high) / 2;
    (darkness(middle) > wanted ? low : high) = middle;
  }
  return high;
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
float brightness_for(const std::vector<Vec3f>& color, const StoneSamples& samples, float wanted) {
  const SampledValues v = sampled(samples, [&](std::size_t i) { return color[i].mean(); });
  const double sum = std::accumulate(v.median.begin(), v.median.end(), 0.0);
  return sum > 0 ? static_cast<float>(wanted * v.median.size() / sum) : 1;
}

}  // namespace

std::vector<Vec3f> exposed(const UnlitPixels& p, const SurfaceOptions& options, const Work& work) {
  const StoneSamples samples(p);
  float share = static_cast<float>(options.light.share);
  if (options.shading && !samples.pixels.empty()) share = sun_share(p, samples, *options.shading);
  work.check();
  std::vector<float> light(p.stone.size());
  for (std::size_t i = 0; i < light.size(); ++i) light[i] = light_of_pixel(p, i, share);
  use_usual_light(p, light);
  work.check();
  const float depth = options.loose ? depth_of_shadows(p, light) : 1;
  std::vector<Vec3f> out = p.color;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] *= shadowed(light[i], depth);
  const float brightness = options.brightness ? brightness_for(out, samples, *options.brightness) : 1;
  for (std::size_t i = 0; i < out.size(); ++i)  // soil has the color that was measured
    out[i] = ((p.stone[i] < 0 ? 1 : brightness) * out[i]).cwiseMax(0.0F).cwiseMin(1.0F);
  return out;
}

}  // namespace terrazzo::view
