// Phases of pixels that tend to be equal at neighbors: a hidden Markov random field.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/media/micrograph/phase_map.h"
#include "runtime/work.h"

namespace terrazzo::media {

using Costs = std::array<double, kMostPhases>;

// `cost(x, y)` is −ln of the probability of each phase without neighbors, up to a constant.
struct PhaseField {
  int width = 0, height = 0, phases = 0;
  double smoothing = 1;  // weight of equal neighbors
  std::vector<std::uint8_t> label;

  // The same with neighbors.
  template <class CostOf>
  Costs energies(int x, int y, CostOf&& cost) const {
    Costs out = cost(x, y);
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int u = x + dx, v = y + dy;
        if ((dx == 0 && dy == 0) || u < 0 || v < 0 || u >= width || v >= height) continue;
        out[label[pixel_at(u, v, width)]] -= smoothing * (dx != 0 && dy != 0 ? std::sqrt(0.5) : 1);
      }
    return out;
  }

  // The most probable phase of each pixel, given its neighbors (Besag 1986), in four sets of pixels that do
  // not touch.
  template <class CostOf>
  void decide(CostOf&& cost, const Work& work) {
    for (int set = 0; set < 4; ++set) {
      const int rows = (height - (set / 2) + 1) / 2;
      work.quiet().parallel(rows, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j)
          for (int y = 2 * static_cast<int>(j) + set / 2, x = set % 2; x < width; x += 2) {
            const Costs e = energies(x, y, cost);
            label[pixel_at(x, y, width)] =
                static_cast<std::uint8_t>(std::min_element(e.begin(), e.begin() + phases) - e.begin());
          }
      });
    }
  }

  // The share of the observed pixels whose phase is less than 90 % sure.
  template <class CostOf>
  double uncertain(const std::vector<std::uint8_t>& observed, CostOf&& cost) const {
    double unsure = 0, n = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const std::size_t at = pixel_at(x, y, width);
        if (!observed[at]) continue;
        const Costs e = energies(x, y, cost);
        double all = 0;
        for (int k = 0; k < phases; ++k) all += std::exp(e[label[at]] - e[k]);
        unsure += 1 / all < 0.9;
        ++n;
      }
    return unsure / n;
  }
};

}  // namespace terrazzo::media
