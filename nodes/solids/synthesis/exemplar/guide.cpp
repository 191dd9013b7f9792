#include "nodes/solids/synthesis/exemplar/guide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "nodes/data/indices.h"

namespace terrazzo::solids {
namespace {

// The largest byte of the darker class (Otsu 1979, maximal variance between classes).
int otsu(const std::array<std::int64_t, 256>& histogram) {
  double count = 0, sum = 0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    count += static_cast<double>(histogram[i]);
    sum += static_cast<double>(i) * static_cast<double>(histogram[i]);
  }
  double below = 0, below_sum = 0, best = 0;
  int threshold = 0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    below += static_cast<double>(histogram[i]);
    below_sum += static_cast<double>(i) * static_cast<double>(histogram[i]);
    if (below == 0 || below == count) continue;
    const double difference = below_sum / below - (sum - below_sum) / (count - below);
    const double variance = below * (count - below) * difference * difference;
    if (variance <= best) continue;
    best = variance;
    threshold = static_cast<int>(i);
  }
  return threshold;
}

double threshold_of(const std::vector<SolidExemplar>& working) {
  std::vector<float> values;
  for (const auto& e : working)
    for (std::size_t i = 0; i < e.pixels.size(); ++i)
      if (e.usable.empty() || e.usable[i]) values.push_back(e.pixels[i][0]);
  if (values.empty()) return 0;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const float from = *low, span = std::max(1e-6f, *high - *low);
  std::array<std::int64_t, 256> histogram{};
  for (const float v : values) ++histogram[static_cast<std::size_t>(std::lround(255 * (v - from) / span))];
  return from + span * (otsu(histogram) + 0.5) / 255;
}

// Distance in pixels from each pixel to the nearest one whose phase is not `phase`, exact up to `reach` and
// larger than it beyond.
std::vector<float> distance_from_others(const std::vector<std::uint8_t>& phases, std::uint8_t phase,
                                        int width, int height, int reach) {
  const int far = reach + 1;
  std::vector<int> along(phases.size(), far);  // distance within the column, at most `far`
  for (int x = 0; x < width; ++x)
    for (const int step : {1, -1})
      for (int k = 0, y = step > 0 ? 0 : height - 1, d = far; k < height; ++k, y += step) {
        const std::size_t i = pixel_at(x, y, width);
        d = phases[i] != phase ? 0 : std::min(d + 1, far);
        along[i] = std::min(along[i], d);
      }
  std::vector<float> distance(phases.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      int square = far * far;
      for (int u = std::max(0, x - reach); u <= std::min(width - 1, x + reach); ++u) {
        const int d = along[pixel_at(u, y, width)];
        square = std::min(square, (u - x) * (u - x) + d * d);
      }
      distance[pixel_at(x, y, width)] = std::sqrt(static_cast<float>(square));
    }
  return distance;
}

}  // namespace

void guide_by_phases(std::vector<SolidExemplar>& working, double weight, int reach) {
  const double level = threshold_of(working);
  double sum = 0, square = 0, count = 0;
  for (auto& e : working) {
    std::vector<std::uint8_t> light(e.pixels.size());
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = e.pixels[i][0] > level;
    // The border is half a pixel from the pixel's center.
    const auto to_dark = distance_from_others(light, 1, e.width, e.height, reach + 1),
               to_light = distance_from_others(light, 0, e.width, e.height, reach + 1);
    e.guide.resize(e.pixels.size());
    for (std::size_t i = 0; i < e.guide.size(); ++i) {
      const float d = light[i] ? to_dark[i] - 0.5f : 0.5f - to_light[i];
      e.guide[i] = std::clamp<float>(d, -reach, reach);
      sum += e.guide[i];
      square += static_cast<double>(e.guide[i]) * e.guide[i];
      ++count;
    }
  }
  const double mean = sum / count, deviation = std::sqrt(std::max(0.0, square / count - mean * mean));
  for (auto& e : working)
    for (float& g : e.guide) g = deviation > 0 ? static_cast<float>(weight * (g - mean) / deviation) : 0;
}

}  // namespace terrazzo::solids
