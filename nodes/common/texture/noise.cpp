#include "nodes/common/texture/noise.h"

#include <cmath>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

std::uint64_t hash(std::uint64_t seed, int x, int y, int z) {
  const auto part = [](int v) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(v)); };
  return mix64(mix64(mix64(seed ^ part(x)) + part(y)) ^ part(z) * 0x9e3779b97f4a7c15ull);
}
double unit(std::uint64_t bits) { return static_cast<double>(bits & 0x1fffff) / 0x1fffff; }

// Dot product with a gradient towards one of the twelve edges of a cube.
double gradient(std::uint64_t h, double x, double y, double z) {
  const auto k = h % 12;
  const double u = k < 4 ? x : k < 8 ? x : y, v = k < 4 ? y : z;
  return (h >> 8 & 1 ? u : -u) + (h >> 9 & 1 ? v : -v);
}

}  // namespace

double noise(std::uint64_t seed, const Vec3& p) {
  const int x = round_down(p.x()), y = round_down(p.y()), z = round_down(p.z());
  const double fx = p.x() - x, fy = p.y() - y, fz = p.z() - z;
  const auto blend = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const double u = blend(fx), v = blend(fy), w = blend(fz);
  double sum = 0;
  for (int k = 0; k < 8; ++k) {
    const int dx = k & 1, dy = k >> 1 & 1, dz = k >> 2;
    sum += (dx ? u : 1 - u) * (dy ? v : 1 - v) * (dz ? w : 1 - w) *
           gradient(hash(seed, x + dx, y + dy, z + dz), fx - dx, fy - dy, fz - dz);
  }
  return sum;
}

double turbulence(std::uint64_t seed, const Vec3& p, int octaves) {
  double sum = 0, amplitude = 1, frequency = 1;
  for (int o = 0; o < octaves; ++o, amplitude /= 2, frequency *= 2)
    sum += amplitude * noise(seed + 0x100 * static_cast<std::uint64_t>(o), frequency * p);
  return sum;
}

Cell cellular(std::uint64_t seed, const Vec3& p) {
  const int x = round_down(p.x()), y = round_down(p.y()), z = round_down(p.z());
  double first = 1e9, second = 1e9;
  Cell out;
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const std::uint64_t h = hash(seed, x + dx, y + dy, z + dz);
        const Vec3 at(x + dx + unit(h), y + dy + unit(h >> 21), z + dz + unit(h >> 42));
        const double d = (p - at).squaredNorm();
        if (d < first) {
          second = first;
          first = d;
          out.shade = unit(mix64(h));
        } else if (d < second)
          second = d;
      }
  out.edge = std::sqrt(second) - std::sqrt(first);
  return out;
}

}  // namespace terrazzo
