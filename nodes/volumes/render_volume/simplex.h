// Simplex noise (Perlin 2001, 2002) in single precision and 32-bit integers, so that the shader gets the same
// values.
#pragma once

#include <cmath>
#include <cstdint>

#include "nodes/data/indices.h"
#include "nodes/data/linear.h"

namespace terrazzo::render_volume {

inline std::uint32_t simplex_hash(std::uint32_t seed, int i, int j, int k) {
  std::uint32_t h = static_cast<std::uint32_t>(i) * 0x8da6b343u ^
                    static_cast<std::uint32_t>(j) * 0xd8163841u ^
                    static_cast<std::uint32_t>(k) * 0xcb1ab31fu ^ seed;
  h = (h ^ h >> 16) * 0x7feb352du;
  h = (h ^ h >> 15) * 0x846ca68bu;
  return h ^ h >> 16;
}

// Mean 0, within −1 … 1; cells about 1 wide.
inline float simplex(std::uint32_t seed, const Vec3f& p) {
  const float skew = (p.x() + p.y() + p.z()) / 3.0f;
  const int i = round_down(p.x() + skew), j = round_down(p.y() + skew), k = round_down(p.z() + skew);
  const float back = float(i + j + k) / 6.0f;
  const Vec3f d(p.x() - (float(i) - back), p.y() - (float(j) - back), p.z() - (float(k) - back));
  // The order of the coordinates selects the edges that lead to the opposite corner.
  const int xy = d.x() >= d.y(), yz = d.y() >= d.z(), xz = d.x() >= d.z();
  const int rank[3] = {xy + xz, (1 - xy) + yz, (1 - xz) + (1 - yz)};
  float sum = 0;
  for (int c = 0; c < 4; ++c) {
    const int o[3] = {rank[0] >= 3 - c, rank[1] >= 3 - c, rank[2] >= 3 - c};
    const float shift = float(c) / 6.0f;
    const float x = d.x() - float(o[0]) + shift, y = d.y() - float(o[1]) + shift,
                z = d.z() - float(o[2]) + shift;
    float t = 0.5f - x * x - y * y - z * z;
    if (t <= 0) continue;
    const std::uint32_t h = simplex_hash(seed, i + o[0], j + o[1], k + o[2]);
    const std::uint32_t e = h % 12;
    const float u = e < 8 ? x : y, v = e < 4 ? y : z;
    t *= t;
    sum += t * t * (((h >> 8 & 1) ? u : -u) + ((h >> 9 & 1) ? v : -v));
  }
  return 76 * sum;
}

}  // namespace terrazzo::render_volume
