#include "nodes/photograph/segment/color/watershed.h"

#include <algorithm>

#include "nodes/data/indices.h"
#include "nodes/photograph/segment/neighbors.h"

namespace terrazzo::segment {
namespace {

constexpr int kLevels = 4096;

std::vector<std::uint16_t> quantized(const std::vector<float>& relief) {
  const auto [low, high] = std::minmax_element(relief.begin(), relief.end());
  const float base = *low, scale = *high > *low ? (kLevels - 1) / (*high - *low) : 0.0f;
  std::vector<std::uint16_t> q(relief.size());
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = static_cast<std::uint16_t>((relief[i] - base) * scale);
  return q;
}

// Numbers the plateaus without a lower neighbor.
std::vector<std::int32_t> minima(const std::vector<std::uint16_t>& q, int width, int height) {
  std::vector<std::int32_t> seeds(q.size(), 0);
  std::vector<std::uint8_t> seen(q.size(), 0);
  std::vector<int> plateau;
  std::int32_t count = 0;
  for (int i = 0; i < count_of(q); ++i) {
    if (seen[i]) continue;
    plateau.assign(1, i);
    seen[i] = 1;
    bool minimum = true;
    for (std::size_t k = 0; k < plateau.size(); ++k)
      neighbors(plateau[k], width, height, [&](int j) {
        if (q[j] < q[i])
          minimum = false;
        else if (q[j] == q[i] && !seen[j]) {
          seen[j] = 1;
          plateau.push_back(j);
        }
      });
    if (!minimum) continue;
    ++count;
    for (const int j : plateau) seeds[j] = count;
  }
  return seeds;
}

std::vector<std::int32_t> flood(const std::vector<std::uint16_t>& q, int width, int height,
                                std::vector<std::int32_t> labels, const std::uint8_t* mask,
                                const Work& work) {
  std::vector<std::vector<int>> queue(kLevels);
  for (int i = 0; i < count_of(q); ++i) {
    if (labels[i] == 0) continue;
    bool edge = false;
    neighbors(i, width, height, [&](int j) { edge = edge || labels[j] == 0; });
    if (edge) queue[q[i]].push_back(i);
  }
  for (int level = 0; level < kLevels; ++level) {
    if (level % 64 == 0) work.check();
    for (std::size_t k = 0; k < queue[level].size(); ++k) {
      const int i = queue[level][k];
      neighbors(i, width, height, [&](int j) {
        if (labels[j] != 0 || (mask && !mask[j])) return;
        labels[j] = labels[i];
        queue[std::max<int>(level, q[j])].push_back(j);
      });
    }
    std::vector<int>().swap(queue[level]);
  }
  return labels;
}

}  // namespace

std::vector<std::int32_t> watershed(const std::vector<float>& relief, int width, int height,
                                    const Work& work) {
  if (relief.empty()) return {};
  const auto q = quantized(relief);
  return flood(q, width, height, minima(q, width, height), nullptr, work);
}

std::vector<std::int32_t> watershed(const std::vector<float>& relief, int width, int height,
                                    const std::vector<std::int32_t>& seeds,
                                    const std::vector<std::uint8_t>& mask, const Work& work) {
  if (relief.empty()) return {};
  return flood(quantized(relief), width, height, seeds, mask.data(), work);
}

}  // namespace terrazzo::segment
