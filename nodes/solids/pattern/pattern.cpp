#include "nodes/solids/pattern/pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/common/texture/color.h"
#include "nodes/common/texture/noise.h"
#include "runtime/random.h"

namespace terrazzo::pattern {
namespace {

Vec3f hex(int rgb) {
  return srgb_to_linear(Vec3f(static_cast<float>(rgb >> 16 & 255), static_cast<float>(rgb >> 8 & 255),
                              static_cast<float>(rgb & 255)) /
                        255.0f);
}
Vec3f mix(const Vec3f& a, const Vec3f& b, double t) {
  return a + static_cast<float>(std::clamp(t, 0.0, 1.0)) * (b - a);
}
double step(double lo, double hi, double v) {
  const double t = std::clamp((v - lo) / (hi - lo), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Growth rings around a distant pith: pale early wood darkens to a sharp edge. Fibers and pores run along z.
Vec3f wood(std::uint64_t seed, const Vec3& p) {
  const Vec3 slow(p.x() * 0.25, p.y() * 0.25, p.z() * 0.04);
  const double r =
      std::hypot(p.x() + 6.3, p.y() + 4.1) + 0.5 * noise(seed, slow) + 0.12 * noise(seed + 1, 3 * slow);
  const double ring = r - std::floor(r);
  const double late = std::pow(ring, 2.5) * (1 - step(0.93, 1, ring));
  const double fiber = turbulence(seed + 2, Vec3(p.x() * 9, p.y() * 9, p.z() * 0.5), 3);
  const double pore = step(0.45, 0.6, noise(seed + 5, Vec3(p.x() * 7, p.y() * 7, p.z() * 0.35)));
  const double shade = 0.95 * late + 0.18 * fiber + 0.35 * pore * (1 - ring);
  return mix(mix(hex(0xd9b382), hex(0x7a4a24), shade), hex(0x9c6a3c), 0.3 + 0.3 * noise(seed + 6, slow));
}

// A pale, cloudy ground with veins of two sizes where warped noise changes sign.
Vec3f marble(std::uint64_t seed, const Vec3& p) {
  const Vec3 q =
      p + 0.7 * Vec3(turbulence(seed, p, 4), turbulence(seed + 10, p, 4), turbulence(seed + 20, p, 4));
  const double wide = 1 - step(0, 0.10, std::abs(noise(seed + 30, 0.6 * q)));
  const double fine = 1 - step(0, 0.07, std::abs(noise(seed + 31, 1.7 * q)));
  const double cloud = turbulence(seed + 32, 1.3 * p, 5);
  const Vec3f ground = mix(hex(0xf1eee8), hex(0xc9c7c4), 0.4 + 0.5 * cloud);
  return mix(mix(ground, hex(0x8e9094), 0.6 * fine), hex(0x43474d), 0.85 * wide);
}

// Bundles of fibers along z in pale sheaths, marbled with fat that follows them.
Vec3f muscle(std::uint64_t seed, const Vec3& p) {
  const Vec3 sway(p.x() + 0.25 * noise(seed, 0.4 * p), p.y() + 0.25 * noise(seed + 1, 0.4 * p), 0.22 * p.z());
  const Cell bundle = cellular(seed + 2, sway);
  const Cell fiber = cellular(seed + 3, Vec3(4.5 * sway.x(), 4.5 * sway.y(), 1.2 * sway.z()));
  const double sheath = 1 - step(0.03, 0.16, bundle.edge), thread = 1 - step(0, 0.25, fiber.edge);
  const double marbling =
      step(0.16, 0.34, turbulence(seed + 4, Vec3(0.9 * p.x(), 0.9 * p.y(), 0.2 * p.z()), 3));
  Vec3f red = mix(hex(0x9c2f33), hex(0x6e1b22), bundle.shade);
  red = mix(red, hex(0xb85a58), 0.4 * thread + 0.2 * (fiber.shade - 0.5));
  red = mix(red, hex(0xd9a49a), 0.75 * sheath);
  return mix(red, hex(0xf0ddcb), 0.9 * marbling);
}

// Lobules separated by thin septa.
Vec3f fat(std::uint64_t seed, const Vec3& p) {
  const Vec3 q = p + 0.2 * Vec3(noise(seed, 2 * p), noise(seed + 1, 2 * p), noise(seed + 2, 2 * p));
  const Cell lobule = cellular(seed + 3, q), cell = cellular(seed + 4, 4 * q);
  const double septum = 1 - step(0.01, 0.10, lobule.edge), wall = 1 - step(0, 0.2, cell.edge);
  Vec3f c = mix(hex(0xf3e2bd), hex(0xe6cb98), lobule.shade);
  c = mix(c, hex(0xfaf0dc), 0.5 * wall);
  return mix(c, hex(0xc98f7a), 0.7 * septum);
}

// Trabeculae, where banded noise is high, in marrow.
Vec3f bone(std::uint64_t seed, const Vec3& p) {
  const double a = noise(seed, 1.1 * p), b = noise(seed + 1, 1.1 * p);
  const double strut = 1 - step(0.07, 0.15, std::min(std::abs(a), std::abs(b)));
  const double grain = turbulence(seed + 2, 5 * p, 3);
  const Vec3f marrow = mix(hex(0x7c2d26), hex(0xa85a3f), 0.5 + 0.8 * grain);
  return mix(marrow, mix(hex(0xeadfc6), hex(0xcdb88f), 0.4 + 0.6 * grain), strut);
}

// Grains of quartz that touch in places, with pores between them.
Vec3f sandstone(std::uint64_t seed, const Vec3& p) {
  const Vec3 q = p + 0.15 * Vec3(noise(seed, 2 * p), noise(seed + 1, 2 * p), noise(seed + 2, 2 * p));
  const double gap = 0.1 + 0.35 * noise(seed + 3, 0.8 * p);
  return cellular(seed + 4, q).edge < gap ? hex(0x303030) : hex(0xb8b8b8);
}

// Particles of active material, which binder with pores connects.
Vec3f electrode(std::uint64_t seed, const Vec3& p) {
  const Vec3 q = p + 0.1 * Vec3(noise(seed, 3 * p), noise(seed + 1, 3 * p), noise(seed + 2, 3 * p));
  const Cell cell = cellular(seed + 3, q);
  if (cell.shade < 0.65 && cell.edge > 0.15) return hex(0xd8d8d8);
  return noise(seed + 4, 2.5 * p) > 0.08 ? hex(0x808080) : hex(0x202020);
}

struct Wave {
  Vec3 direction;
  double start = 0;  // of a period
};

std::vector<Wave> waves(const PatternOptions& c) {
  constexpr std::uint64_t kWaves = 64;
  std::vector<Wave> out;
  for (std::uint64_t k = 0; c.kind == Kind::Copolymer && k < kWaves; ++k) {
    Random random(c.seed, 7, k);
    Wave& w = out.emplace_back();
    w.direction = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    w.start = random.uniform();
  }
  return out;
}

// The sign of waves of one length in random directions (Cahn 1965).
Vec3f copolymer(const std::vector<Wave>& waves, const Vec3& p) {
  double sum = 0;
  for (const Wave& w : waves) sum += std::cos(2 * std::numbers::pi * (w.direction.dot(p) + w.start));
  return sum > 0 ? hex(0xc8c8c8) : hex(0x404040);
}

// `waves` of these options.
Vec3f color_at(const PatternOptions& c, const std::vector<Wave>& waves, const Vec3& point) {
  // Keep sections off the planes of the noise lattice, where gradient noise is flat and shows its axes.
  const Vec3 p = point / c.scale + Vec3(0.37, 0.21, 0.43);
  if (c.kind == Kind::Muscle) return muscle(c.seed, p);
  if (c.kind == Kind::Wood) return wood(c.seed, p);
  static const Mat3 oblique = Quat(0.83, 0.31, -0.37, 0.27).normalized().toRotationMatrix();
  const Vec3 q = oblique * p;
  switch (c.kind) {
    case Kind::Marble:
      return marble(c.seed, q);
    case Kind::Fat:
      return fat(c.seed, q);
    case Kind::Sandstone:
      return sandstone(c.seed, q);
    case Kind::Electrode:
      return electrode(c.seed, q);
    case Kind::Copolymer:
      return copolymer(waves, q);
    default:
      return bone(c.seed, q);
  }
}

}  // namespace

Vec3f pattern_color(const PatternOptions& c, const Vec3& point) { return color_at(c, waves(c), point); }

Image pattern_image(const PatternOptions& c, const Work& work) {
  Image out(c.width, c.height, 1, c.pixel_size);
  const int axis = c.axis;
  const std::vector<Wave> of_seed = waves(c);
  work.parallel(c.height, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y)
      for (int x = 0; x < c.width; ++x) {
        Vec3f sum = Vec3f::Zero();
        for (int s = 0; s < 4; ++s) {
          Vec3 p;
          p[axis] = c.offset;
          p[kSliceColumns[axis]] = (x + 0.25 + 0.5 * (s & 1)) * c.pixel_size;
          p[kSliceRows[axis]] = (c.height - 1 - static_cast<int>(y) + 0.25 + 0.5 * (s >> 1)) * c.pixel_size;
          sum += color_at(c, of_seed, p) / 4;
        }
        out.at(x, static_cast<int>(y)) = sum;
      }
  });
  return out;
}

}  // namespace terrazzo::pattern
