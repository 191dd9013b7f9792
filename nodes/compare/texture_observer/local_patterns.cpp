#include "nodes/compare/texture_observer/local_patterns.h"

#include <array>
#include <cmath>

#include "nodes/data/indices.h"

namespace terrazzo::texture_observer {

namespace {

struct Neighbor {  // bilinear weights of the four pixels around a point of the circle
  int x, y;
  float weight[4];
};

std::array<Neighbor, 8> circle(int radius) {
  std::array<Neighbor, 8> out;
  for (int k = 0; k < 8; ++k) {
    // Points on the axes are exact pixels; sin and cos are not exactly 0 there.
    const double x = k % 4 == 2 ? 0 : radius * std::cos(M_PI * k / 4),
                 y = k % 4 == 0 ? 0 : radius * std::sin(M_PI * k / 4);
    const double left = std::floor(x), top = std::floor(y), u = x - left, v = y - top;
    out[k] = {static_cast<int>(left),
              static_cast<int>(top),
              {static_cast<float>((1 - u) * (1 - v)), static_cast<float>(u * (1 - v)),
               static_cast<float>((1 - u) * v), static_cast<float>(u * v)}};
  }
  return out;
}

// The code of every set of lighter neighbors.
std::array<std::uint8_t, 256> codes() {
  std::array<std::uint8_t, 256> table;
  for (int bits = 0; bits < 256; ++bits) {
    int set = 0, changes = 0;
    for (int k = 0; k < 8; ++k) {
      set += bits >> k & 1;
      changes += (bits >> k & 1) != (bits >> (k + 1) % 8 & 1);
    }
    table[bits] = changes <= 2 ? set : 9;
  }
  return table;
}

}  // namespace

std::vector<std::uint8_t> local_patterns(const Patch& patch, int radius) {
  constexpr float kEqual = 1e-5f;  // far below a step of 8 bits, far above rounding
  static const auto code = codes();
  const auto neighbors = circle(radius);
  std::vector<std::uint8_t> out(patch.lab.size(), 0);
  for (int y = radius; y < patch.height - radius; ++y)
    for (int x = radius; x < patch.width - radius; ++x) {
      const float center = patch.at(x, y)[0] - kEqual;
      int bits = 0;
      for (int k = 0; k < 8; ++k) {
        const auto& n = neighbors[k];
        float light = 0;
        for (int corner = 0; corner < 4; ++corner)
          if (n.weight[corner] > 0)
            light += n.weight[corner] * patch.at(x + n.x + corner % 2, y + n.y + corner / 2)[0];
        bits |= (light >= center) << k;
      }
      out[pixel_at(x, y, patch.width)] = code[bits];
    }
  return out;
}

}  // namespace terrazzo::texture_observer
