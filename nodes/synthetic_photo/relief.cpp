#include "nodes/synthetic_photo/relief.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/noise.h"
#include "nodes/synthetic_photo/stone.h"

namespace terrazzo::synthetic_photo {
namespace {

// Octaves of noise from the largest hills to crumbs, plain or with ridges like clods that broke apart.
class Ground {
 public:
  Ground(Random& r, double side)
      : seed_(r.bits()),
        size_(side * r.uniform(0.3, 1.2)),
        height_(r.uniform(0.1, 1) * r.uniform(0.02, 0.3) * size_),
        rough_(r.uniform(0.35, 0.75)),
        ridged_(r.uniform() < 0.35 ? r.uniform(0.2, 1) : 0),
        ledges_(r.uniform() < 0.2 ? r.uniform(4, 30) : 0),
        ledge_size_(side * r.uniform(0.1, 0.5)) {}

  // Octaves above and below a wavelength of `split` canvas pixels.
  double coarse(const Vec3& p, double split) const {
    double sum = ledges_ > 0 ? ledge(p) : 0;
    return sum + octaves(p, split, true);
  }
  double fine(const Vec3& p, double split) const { return octaves(p, split, false); }

 private:
  double octaves(const Vec3& p, double split, bool above) const {
    double sum = 0, size = size_, height = height_;
    for (int k = 0; k < 9 && size > 4; ++k, size /= 2, height *= rough_) {
      if ((size >= split) != above) continue;
      const double n = noise(seed_ + k, p / size);
      sum += height * ((1 - ridged_) * n + ridged_ * (0.5 - 2 * std::abs(n)));
    }
    return sum;
  }
  // Layers of a bank that weather differently.
  double ledge(const Vec3& p) const {
    const double t = p.y() / ledge_size_ + 0.6 * turbulence(seed_ + 50, p / (2 * ledge_size_), 2);
    const double f = t - std::floor(t);
    return ledges_ * (f < 0.75 ? f / 0.75 : (1 - f) / 0.25);
  }
  std::uint64_t seed_;
  double size_, height_, rough_, ridged_, ledges_, ledge_size_;
};

void make_soil(Canvas& c, const PhotoPalette& palette, Random& r, const Work& work) {
  const Texture texture = palette.ground(r);
  const Ground ground(r, std::sqrt(static_cast<double>(c.width) * c.height));
  const double grain = r.uniform(0, 2.2), grain_size = r.uniform(2, 6);
  const double shaded = r.uniform(0, 0.4), damp = r.uniform() < 0.5 ? r.uniform(0, 0.5) : 0,
               damp_size = r.uniform(40, 300);
  const std::uint64_t seed = r.bits();
  // The large octaves are smooth: every fourth point is enough.
  constexpr int kStep = 4;
  constexpr double kSplit = 24;
  const int cw = c.width / kStep + 2, ch = c.height / kStep + 2;
  std::vector<float> coarse(static_cast<std::size_t>(cw) * ch), wet(coarse.size());
  for (int y = 0; y < ch; ++y)
    for (int x = 0; x < cw; ++x) {
      const Vec3 p(x * kStep, y * kStep, 0);
      const std::size_t k = static_cast<std::size_t>(y) * cw + x;
      coarse[k] = static_cast<float>(ground.coarse(p, kSplit));
      wet[k] = static_cast<float>(
          1 - damp * std::clamp(0.5 + 2 * turbulence(seed + 3, p / damp_size, 3), 0.0, 1.0));
    }
  for (int y = 0; y < c.height; ++y) {
    work.check();
    for (int x = 0; x < c.width; ++x) {
      const Vec3 p(x, y, 0);
      const std::size_t i = c.at(x, y), k = static_cast<std::size_t>(y / kStep) * cw + x / kStep;
      const float u = static_cast<float>(x % kStep) / kStep, v = static_cast<float>(y % kStep) / kStep;
      const auto between = [&](const std::vector<float>& f) {
        return (1 - v) * ((1 - u) * f[k] + u * f[k + 1]) + v * ((1 - u) * f[k + cw] + u * f[k + cw + 1]);
      };
      const double crumbs = noise(seed + 9, p / grain_size);
      c.z[i] = between(coarse) + static_cast<float>(ground.fine(p, kSplit) + grain * crumbs);
      c.color[i] = texture(p) * between(wet) * static_cast<float>(std::max(0.2, 1 + shaded * crumbs));
    }
  }
  for (int pits = static_cast<int>(r.below(7)) - 2; pits > 0; --pits) {
    const double px = r.uniform(0, c.width), py = r.uniform(0, c.height), size = r.uniform(6, 45),
                 depth = size * r.uniform(0.3, 1.2);
    const std::uint64_t s = r.bits();
    for (int y = std::max(0, static_cast<int>(py - 2 * size)); y < std::min<double>(c.height, py + 2 * size);
         ++y)
      for (int x = std::max(0, static_cast<int>(px - 2 * size)); x < std::min<double>(c.width, px + 2 * size);
           ++x) {
        const double d = std::hypot(x - px, y - py) / size + 0.7 * turbulence(s, Vec3(x, y, 0) / size, 2);
        if (d < 1) c.z[c.at(x, y)] -= static_cast<float>(depth * (1 - d * d));
      }
  }
}

struct Placed {
  double x = 0, y = 0, middle = 0;  // of the stone's middle plane
};

// Draws the stone into the height map; `id` 0 leaves it unlabeled. Mud of the soil's color covers a part.
void draw(Canvas& c, const Stone& stone, const Placed& at, const Texture& texture, float gloss, int id,
          double mud, const Vec3f& mud_color, std::uint64_t mud_seed) {
  const double reach = stone.reach();
  const double scale = std::max(6.0, 0.7 * reach);
  for (int y = std::max(0, static_cast<int>(at.y - reach)); y <= std::min<double>(c.height - 1, at.y + reach);
       ++y)
    for (int x = std::max(0, static_cast<int>(at.x - reach));
         x <= std::min<double>(c.width - 1, at.x + reach); ++x) {
      const double h = stone.top(x - at.x, y - at.y);
      if (std::isnan(h)) continue;
      const std::size_t i = c.at(x, y);
      const auto z = static_cast<float>(at.middle + h);
      if (z <= c.z[i]) continue;
      c.z[i] = z, c.id[i] = id, c.gloss[i] = gloss;
      Vec3f color = texture(Vec3(x - at.x, y - at.y, 0.7 * h));
      if (mud > 0) {
        const double cover =
            0.5 + 1.2 * turbulence(mud_seed, Vec3(x, y, 0) / scale, 3) + 0.3 * (y - at.y) / reach;
        const double t = std::clamp((mud - cover) * 6, 0.0, 1.0);
        color += static_cast<float>(t) * (c.color[i] * 0.3f + mud_color * 0.7f - color);
      }
      c.color[i] = color;
    }
}

// Fine gravel without labels: without it a network marks every grain of sand.
void scatter_gravel(Canvas& c, const PhotoPalette& palette, Random& r, const Work& work) {
  for (int layers = static_cast<int>(r.below(4)); layers > 0; --layers) {
    const double largest = r.uniform(2, 7), cover = r.uniform(0.02, 0.6), area = c.width * c.height;
    const double contrast = r.uniform(0.1, 1);
    for (double covered = 0; covered < cover * area;) {
      work.check();
      const double radius = largest * (0.35 + 0.65 * r.uniform() * r.uniform());
      const double px = r.uniform(0, c.width), py = r.uniform(0, c.height), flat = r.uniform(0.5, 1);
      Vec3f color = palette.particle(r, radius).color;
      color = palette.ground_color() + static_cast<float>(contrast) * (color - palette.ground_color());
      covered += 3.14 * radius * radius;
      const int reach = static_cast<int>(radius) + 1;
      const int cx = static_cast<int>(px), cy = static_cast<int>(py);
      const float base = c.z[c.at(cx, cy)] - static_cast<float>(radius * flat * r.uniform(0, 0.7));
      for (int y = std::max(0, cy - reach); y <= std::min(c.height - 1, cy + reach); ++y)
        for (int x = std::max(0, cx - reach); x <= std::min(c.width - 1, cx + reach); ++x) {
          const double d2 = ((x - px) * (x - px) + (y - py) * (y - py)) / (radius * radius);
          if (d2 >= 1) continue;
          const float z = base + static_cast<float>(radius * flat * std::sqrt(1 - d2));
          const std::size_t i = c.at(x, y);
          if (z > c.z[i] && c.id[i] == 0) c.z[i] = z, c.color[i] = color;
        }
    }
  }
}

double power_law(Random& r, double lo, double hi, double exponent) {
  const double e = 1 - exponent, u = r.uniform();
  if (std::abs(e) < 1e-6) return lo * std::pow(hi / lo, u);
  return std::pow(std::pow(lo, e) + u * (std::pow(hi, e) - std::pow(lo, e)), 1 / e);
}

struct Footprint {
  double ground = 0;    // a middle height of what lies there
  double occupied = 0;  // share of the samples on stones
};

Footprint look_under(const Canvas& c, double x, double y, double radius) {
  std::vector<float> heights;
  int taken = 0;
  for (int k = 0; k < 25; ++k) {
    const double a = 2.399963 * k, d = radius * std::sqrt((k + 0.5) / 25);
    const int px = std::clamp(static_cast<int>(x + d * std::cos(a)), 0, c.width - 1),
              py = std::clamp(static_cast<int>(y + d * std::sin(a)), 0, c.height - 1);
    heights.push_back(c.z[c.at(px, py)]);
    taken += c.id[c.at(px, py)] > 0;
  }
  std::nth_element(heights.begin(), heights.begin() + 12, heights.end());
  return {heights[12], taken / 25.0};
}

}  // namespace

void make_relief(Canvas& c, const ReliefOptions& options, const PhotoPalette& palette, Random& r,
                 const Work& work) {
  make_soil(c, palette, r, work);
  scatter_gravel(c, palette, r, work);
  const StoneFamily family(r);
  const double area = static_cast<double>(c.width) * c.height, side = std::sqrt(area);
  const double smallest = r.uniform(7, 18);
  const double largest =
      std::min(0.8 * side, std::max(1.5 * smallest, 14 * std::pow(r.uniform(2, 60), r.uniform(0.4, 1))));
  const double exponent = r.uniform(1.2, 3.2);
  const double allowed = options.heap ? 1 : r.uniform() < 0.4 ? 0.02 : r.uniform(0.02, 0.6);
  const double deepest = options.heap ? 0.1 : r.uniform(0.1, 0.95);
  const double wet = r.uniform() < 0.2 ? r.uniform(0.2, 1) : 0;
  const double muddy = r.uniform() < 0.5 ? r.uniform(0, 0.9) : 0;
  std::vector<double> radii;
  for (double sum = 0; sum < options.fill * area && radii.size() < 1500;) {
    const double radius = power_law(r, smallest, largest, exponent);
    // A boulder that alone exceeds what is wanted is left out most of the time.
    if (3.14 * radius * radius > 1.5 * (options.fill * area - sum) + 0.1 * area && r.uniform() < 0.8) {
      sum += 0.01 * area;
      continue;
    }
    radii.push_back(radius), sum += 3.14 * radius * radius;
  }
  // In a bank the large stones come first and small ones fill the gaps; in a heap any order occurs.
  std::sort(radii.begin(), radii.end(), std::greater<>());
  if (options.heap && r.uniform() < 0.7)
    for (std::size_t i = radii.size(); i > 1; --i) std::swap(radii[i - 1], radii[r.below(i)]);
  const std::vector<float> soil = c.z;
  for (const double radius : radii) {
    work.check();
    Placed at;
    Footprint under;
    bool placed = false;
    for (int attempt = 0; attempt < 14 && !placed; ++attempt) {
      at.x = r.uniform(-0.3 * radius, c.width + 0.3 * radius);
      at.y = r.uniform(-0.3 * radius, c.height + 0.3 * radius);
      under = look_under(c, at.x, at.y, radius);
      placed = under.occupied <= allowed;
    }
    if (!placed) continue;
    const Stone stone(r, family, radius);
    const double buried = deepest * r.uniform() * (r.uniform() < 0.15 ? 1.6 : 1);
    at.middle = under.ground + stone.height() * (options.heap ? 0.3 - buried : 0.5 - 1.3 * buried);
    const double mud = r.uniform() < muddy ? r.uniform(0.1, 0.9) : 0;
    draw(c, stone, at, palette.particle(r, radius), static_cast<float>(wet * r.uniform(0.5, 1)),
         ++c.particles, mud, palette.ground_color(), r.bits());
  }
}

}  // namespace terrazzo::synthetic_photo
