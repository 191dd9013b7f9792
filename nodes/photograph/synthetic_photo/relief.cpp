#include "nodes/photograph/synthetic_photo/relief.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/noise.h"
#include "nodes/photograph/synthetic_photo/soil.h"
#include "nodes/photograph/synthetic_photo/stone.h"

namespace terrazzo::synthetic_photo {
namespace {

struct Placed {
  double x = 0, y = 0, middle = 0;  // of the stone's middle plane
};

// Draws the stone into the height map; without a texture it is a lump of what lies there, unlabeled. Mud of
// the soil's color covers a part.
void draw(Canvas& c, const Stone& stone, const Placed& at, const Texture* texture, float gloss, int id,
          double mud, const Vec3f& mud_color, std::uint64_t mud_seed) {
  const double reach = stone.reach();
  const double scale = std::max(6.0, 0.7 * reach);
  for (int y = std::max<int>(0, at.y - reach); y <= std::min<double>(c.height - 1, at.y + reach); ++y)
    for (int x = std::max<int>(0, at.x - reach); x <= std::min<double>(c.width - 1, at.x + reach); ++x) {
      const double h = stone.top(x - at.x, y - at.y);
      if (std::isnan(h)) continue;
      const std::size_t i = c.at(x, y);
      const float z = at.middle + h;
      if (z <= c.z[i]) continue;
      c.z[i] = z;
      if (texture == nullptr) continue;
      c.id[i] = id;
      c.gloss[i] = gloss;
      Vec3f color = (*texture)(Vec3(x - at.x, y - at.y, 0.7 * h));
      if (mud > 0) {
        const double cover =
            0.5 + 1.2 * turbulence(mud_seed, Vec3(x, y, 0) / scale, 3) + 0.3 * (y - at.y) / reach;
        const double t = std::clamp((mud - cover) * 6, 0.0, 1.0);
        color += static_cast<float>(t) * (c.color[i] * 0.3f + mud_color * 0.7f - color);
      }
      c.color[i] = color;
    }
}

double power_law(Random& r, double lo, double hi, double exponent) {
  const double e = 1 - exponent, u = r.uniform();
  if (std::abs(e) < 1e-6) return lo * std::pow(hi / lo, u);
  return std::pow(std::pow(lo, e) + u * (std::pow(hi, e) - std::pow(lo, e)), 1 / e);
}

// Lumps of soil: without them a network takes whatever bulges for a stone.
void scatter_clods(Canvas& c, Random& r, const Work& work) {
  StoneFamily family(r);
  family.bumps = r.uniform(0.05, 0.25);
  const double largest = r.uniform(6, 60);
  for (int clods = r.uniform(2, 60 * 20 / largest); clods > 0; --clods) {
    work.check();
    const double radius = largest * r.uniform(0.3, 1);
    const Stone clod(r, family, radius);
    const Placed at{r.uniform(0, c.width), r.uniform(0, c.height), 0};
    const float under = c.z[c.at(static_cast<int>(at.x), static_cast<int>(at.y))];
    draw(c, clod, {at.x, at.y, under - clod.height() * r.uniform(0.3, 0.9)}, nullptr, 0, 0, 0, Vec3f::Zero(),
         0);
  }
}

// Soil that slid down or stuck: it rises unevenly and covers the feet of the stones, so that their outlines
// are ragged where they dip into it.
void cover_feet(Canvas& c, const std::vector<float>& soil, const std::vector<Vec3f>& soil_color,
                double smallest, Random& r) {
  const double thick = smallest * r.uniform(0.1, 0.9), size = r.uniform(6, 60), edge = r.uniform(0.5, 2);
  const double bias = r.uniform(-0.3, 0.5);
  const std::uint64_t seed = r.bits();
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      const std::size_t i = c.at(x, y);
      const double more = std::clamp(bias + 1.5 * turbulence(seed, Vec3(x, y, 0) / size, 4), 0.0, 1.0);
      const float level = soil[i] + thick * more;
      const float over = level - c.z[i];
      if (more <= 0 || over <= 0) continue;
      c.z[i] = level;
      if (c.id[i] == 0) continue;
      // A film shows what is below.
      c.color[i] += std::min<float>(1.0f, over / edge) * (soil_color[i] - c.color[i]);
      if (over > 0.5 * edge) {
        c.id[i] = 0;
        c.gloss[i] = 0;
      }
    }
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
    const int px = std::clamp<int>(x + d * std::cos(a), 0, c.width - 1),
              py = std::clamp<int>(y + d * std::sin(a), 0, c.height - 1);
    heights.push_back(c.z[c.at(px, py)]);
    taken += c.id[c.at(px, py)] > 0;
  }
  return {median(std::move(heights)), taken / 25.0};
}

}  // namespace

void make_relief(Canvas& c, const ReliefOptions& options, const PhotoPalette& palette, Random& r,
                 const Work& work) {
  make_soil(c, palette, r, work);
  const StoneFamily family(r);
  if (r.uniform() < 0.12) scatter_clods(c, r, work);
  const double area = static_cast<double>(c.width) * c.height, side = std::sqrt(area);
  const double smallest = r.uniform(5, 17);
  const double largest =
      std::min(0.8 * side, std::max(1.5 * smallest, 14 * std::pow(r.uniform(2, 60), r.uniform(0.4, 1))));
  const double exponent = r.uniform(1.2, 3.6);
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
    radii.push_back(radius);
    sum += 3.14 * radius * radius;
  }
  // In a bank the large stones come first and small ones fill the gaps; in a heap any order occurs.
  std::sort(radii.begin(), radii.end(), std::greater<>());
  if (options.heap && r.uniform() < 0.7)
    for (std::size_t i = radii.size(); i > 1; --i) std::swap(radii[i - 1], radii[r.below(i)]);
  // Water sorts: stones lie close together in some places and are rare in others.
  const double clusters = r.uniform() < 0.6 ? r.uniform(0.5, 4) : 0,
               cluster_size = side * r.uniform(0.1, 0.5);
  const std::uint64_t cluster_seed = r.bits();
  const bool covered = !options.heap && r.uniform() < 0.5;
  const std::vector<float> soil = c.z;
  const std::vector<Vec3f> soil_color = covered ? c.color : std::vector<Vec3f>();
  for (const double radius : radii) {
    work.check();
    Placed at;
    Footprint under;
    bool placed = false;
    for (int attempt = 0; attempt < 14 && !placed; ++attempt) {
      at.x = r.uniform(-0.3 * radius, c.width + 0.3 * radius);
      at.y = r.uniform(-0.3 * radius, c.height + 0.3 * radius);
      if (clusters > 0 && radius < 0.1 * side) {
        const double likely =
            0.5 + clusters * turbulence(cluster_seed, Vec3(at.x, 2 * at.y, 0) / cluster_size, 2);
        if (r.uniform() > likely) continue;
      }
      under = look_under(c, at.x, at.y, radius);
      placed = under.occupied <= allowed;
    }
    if (!placed) continue;
    const Stone stone(r, family, radius);
    const double buried = deepest * r.uniform() * (r.uniform() < 0.15 ? 1.6 : 1);
    at.middle = under.ground + stone.height() * (options.heap ? 0.3 - buried : 0.5 - 1.3 * buried);
    const double mud = r.uniform() < muddy ? r.uniform(0.1, 0.9) : 0;
    const Texture texture = palette.stone(r, radius);
    draw(c, stone, at, &texture, wet * r.uniform(0.5, 1), ++c.particles, mud, palette.ground_color(),
         r.bits());
  }
  if (covered) cover_feet(c, soil, soil_color, smallest, r);
  if (r.uniform() < (options.heap ? 0.1 : 0.15)) spread_clay(c, palette, r, work);
}

}  // namespace terrazzo::synthetic_photo
