#include "nodes/photograph/synthetic_photo/plane_section.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/noise.h"
#include "nodes/photograph/synthetic_photo/cells.h"
#include "nodes/photograph/synthetic_photo/joined_grains.h"

namespace terrazzo::synthetic_photo {
namespace {

// A profile of radius about 1.
struct Outline {
  enum class Kind { Disc, Bumpy, Polygon, Cuboid, Lobed } kind = Kind::Disc;
  double axis = 1, cosine = 1, sine = 0, power = 2;
  std::vector<double> angle, distance;  // half planes of a polygon
  double wave[7] = {}, phase[7] = {};
  struct Lobe {
    double x, y, radius;
  };
  std::vector<Lobe> lobes;  // grains that grew together without a border
  double reach = 1;

  bool inside(double x, double y) const {
    const double u = (cosine * x + sine * y) / axis, v = (cosine * y - sine * x) * axis;
    switch (kind) {
      case Kind::Disc:
        return u * u + v * v < 1;
      case Kind::Cuboid:
        return std::pow(std::abs(u), power) + std::pow(std::abs(v), power) < 0.8;
      case Kind::Polygon:
        for (std::size_t i = 0; i < angle.size(); ++i)
          if (std::cos(angle[i]) * u + std::sin(angle[i]) * v > distance[i]) return false;
        return u * u + v * v < 4;
      case Kind::Bumpy: {
        const double a = std::atan2(v, u);
        double edge = 1;
        for (int k = 0; k < 7; ++k) edge += wave[k] * std::cos((k + 2) * a + phase[k]);
        return std::hypot(u, v) < std::max(0.25, edge);
      }
      case Kind::Lobed:
        // A smooth union: the lobes' bays are rounded.
        double sum = 0;
        for (const Lobe& l : lobes) {
          const double d = ((u - l.x) * (u - l.x) + (v - l.y) * (v - l.y)) / (l.radius * l.radius);
          sum += std::exp(6 * (1 - d));
        }
        return sum > 1;
    }
    return false;
  }
};

struct Family {
  double disc, polygon, cuboid, lobed;  // shares; the rest is bumpy
  double elongation, bumps, common_turn;
  bool aligned;
  int corners;
  Family(Random& r, bool grown) {
    const double which = r.uniform();
    disc = which < 0.15 ? r.uniform(0.7, 1) : r.uniform() < 0.2 ? r.uniform(0, 0.5) : 0;
    polygon = which > 0.6 ? r.uniform(0.5, 1) : r.uniform() < 0.5 ? r.uniform() : 0;
    cuboid = which > 0.15 && which < 0.25 ? 1 : 0;
    lobed = r.uniform() < (grown ? 0.7 : 0.15) ? r.uniform(0.1, 0.8) : 0;
    elongation = r.uniform() < 0.2 ? r.uniform(2, 5) : r.uniform(1.05, 2.2);
    bumps = r.uniform(0, 0.18);
    aligned = r.uniform() < 0.2;
    common_turn = r.uniform(0, 6.2832);
    corners = 3 + static_cast<int>(r.below(6));
  }
  void make_round() {
    disc = 1;
    polygon = cuboid = lobed = 0;
    elongation = std::min(elongation, 1.5);
  }
  Outline draw(Random& r) const {
    Outline o;
    const double kind = r.uniform();
    o.kind = kind < cuboid                    ? Outline::Kind::Cuboid
             : kind < cuboid + disc           ? Outline::Kind::Disc
             : kind < cuboid + disc + polygon ? Outline::Kind::Polygon
                                              : Outline::Kind::Bumpy;
    if (r.uniform() < lobed) o.kind = Outline::Kind::Lobed;
    if (o.kind != Outline::Kind::Disc || r.uniform() < 0.3) o.axis = std::sqrt(r.uniform(1, elongation));
    const double turn = aligned ? common_turn + 0.15 * r.normal() : r.uniform(0, 6.2832);
    o.cosine = std::cos(turn);
    o.sine = std::sin(turn);
    o.power = r.uniform(3, 8);
    o.reach = 1.5 * o.axis;
    if (o.kind == Outline::Kind::Polygon) {
      const int n = corners + static_cast<int>(r.below(4));
      const double first = r.uniform(0, 6.2832);
      for (int i = 0; i < n; ++i) {
        o.angle.push_back(first + 6.2832 * (i + r.uniform(-0.35, 0.35)) / n);
        o.distance.push_back(r.uniform(0.55, 1.05));
      }
      o.reach = 2 * o.axis;
    }
    if (o.kind == Outline::Kind::Lobed) {
      // Each lobe overlaps an earlier one by so much that no narrow neck remains.
      o.lobes.push_back({0, 0, r.uniform(0.5, 0.9)});
      o.reach = o.lobes[0].radius;
      for (int n = 1 + static_cast<int>(r.below(4)); n > 0; --n) {
        const Outline::Lobe& from = o.lobes[r.below(o.lobes.size())];
        const double size = from.radius * r.uniform(0.55, 1.2), angle = r.uniform(0, 6.2832),
                     apart = std::max(from.radius, size) * r.uniform(0.7, 1.1);
        const Outline::Lobe l{from.x + apart * std::cos(angle), from.y + apart * std::sin(angle), size};
        o.reach = std::max(o.reach, std::hypot(l.x, l.y) + size);
        o.lobes.push_back(l);
      }
      o.reach *= 1.2 * o.axis;
    }
    if (o.kind == Outline::Kind::Bumpy) {
      for (int k = 0; k < 7; ++k) {
        o.wave[k] = bumps * r.normal() / (1 + 0.5 * k);
        o.phase[k] = r.uniform(0, 6.2832);
      }
      o.reach = 1.8 * o.axis;
    }
    return o;
  }
};

// Radius of a profile: a particle's radius from a law, cut at a random height, as in a real section.
class Sizes {
 public:
  explicit Sizes(Random& r, double side) {
    smallest_ = r.uniform(5, 14);
    largest_ = std::min(0.45 * side, smallest_ * std::pow(r.uniform(1.3, 40), r.uniform(0.3, 1)));
    law_ = r.below(4);
    exponent_ = r.uniform(1, 3.5);
    spread_ = r.uniform(0.1, 0.7);
    cut_ = r.uniform() < 0.7;
  }
  double draw(Random& r) const {
    double radius = largest_;
    if (law_ == 1) radius = r.uniform(smallest_, largest_);
    if (law_ == 2) radius = std::sqrt(smallest_ * largest_) * std::exp(spread_ * r.normal());
    if (law_ == 3) {
      const double e = 1 - exponent_;
      radius = std::abs(e) < 1e-6 ? smallest_ * std::pow(largest_ / smallest_, r.uniform())
                                  : std::pow(std::pow(smallest_, e) + r.uniform() * (std::pow(largest_, e) -
                                                                                     std::pow(smallest_, e)),
                                             1 / e);
    }
    radius = std::clamp(radius, 4.0, largest_ * 1.5);
    const double height = r.uniform();
    return cut_ ? std::max(3.0, radius * std::sqrt(1 - height * height)) : radius;
  }
  // Particles much smaller than others, such as those that precipitated later.
  static Sizes fine(Random& r, double scale = 1) {
    Sizes s(r, 100);
    s.smallest_ = scale * r.uniform(3, 6);
    s.largest_ = s.smallest_ * r.uniform(1.2, 2.5);
    s.law_ = 1;
    return s;
  }
  double middle() const { return std::sqrt(smallest_ * largest_); }

 private:
  double smallest_, largest_, exponent_, spread_;
  int law_;
  bool cut_;
};

// Adds particles to those that are there, never closer to them than `least_apart` canvas pixels.
void drop_shapes(Canvas& c, double fill, const Sizes& sizes, const Family& family, double least_apart,
                 Random& r, const Work& work) {
  const double area = static_cast<double>(c.width) * c.height;
  const double apart = least_apart + (r.uniform() < 0.5 ? 0 : r.uniform(0, 4)),
               warp = r.uniform() < 0.5 ? r.uniform(0, 3) : 0, warp_size = r.uniform(8, 40);
  const std::uint64_t seed = r.bits();
  // In half of the pictures with fine particles, these lie in clusters.
  const double cluster_size = r.uniform(30, 120), rarity = least_apart > 0 && r.uniform() < 0.5 ? 0.1 : -2;
  std::vector<double> radii;
  for (double sum = 0; sum < 1.15 * fill * area && radii.size() < 2500;) {
    radii.push_back(sizes.draw(r));
    sum += 2.8 * radii.back() * radii.back();
  }
  std::sort(radii.begin(), radii.end(), std::greater<>());
  std::vector<std::size_t> pixels;
  for (const double radius : radii) {
    work.check();
    const Outline outline = family.draw(r);
    for (int attempt = 0; attempt < 30; ++attempt) {
      const double px = r.uniform(-0.5 * radius, c.width + 0.5 * radius),
                   py = r.uniform(-0.5 * radius, c.height + 0.5 * radius);
      if (noise(seed + 2, Vec3(px, py, 0) / cluster_size) < rarity) continue;
      // A few probes reject most positions quickly.
      bool free = true;
      for (int k = 0; k < 9 && free; ++k) {
        const double d = (k == 0 ? 0 : 0.9) * radius + (k == 0 ? 0 : apart);
        const int x = static_cast<int>(px + d * std::cos(0.785 * k)),
                  y = static_cast<int>(py + d * std::sin(0.785 * k));
        if (x >= 0 && y >= 0 && x < c.width && y < c.height) free = c.id[c.at(x, y)] == 0;
      }
      if (!free) continue;
      pixels.clear();
      std::size_t taken = 0;
      const double reach = outline.reach * radius + warp;
      for (int y = std::max<int>(0, py - reach); y <= std::min<double>(c.height - 1, py + reach); ++y)
        for (int x = std::max<int>(0, px - reach); x <= std::min<double>(c.width - 1, px + reach); ++x) {
          double wx = x - px, wy = y - py;
          if (warp > 0) {
            wx += warp * noise(seed, Vec3(x, y, 0) / warp_size);
            wy += warp * noise(seed + 1, Vec3(x, y, 0) / warp_size);
          }
          if (!outline.inside(wx / radius, wy / radius)) continue;
          if (c.id[c.at(x, y)] != 0)
            ++taken;
          else
            pixels.push_back(c.at(x, y));
        }
      if (pixels.empty() || taken > 0.04 * pixels.size()) continue;
      ++c.particles;
      for (const auto i : pixels) c.id[i] = c.particles;
      break;
    }
  }
}

// Seeds of cells that cover the canvas; some are binder.
std::vector<CellSeed> draw_seeds(const Canvas& c, double fill, const Sizes& sizes, Random& r) {
  std::vector<CellSeed> seeds;
  const double area = static_cast<double>(c.width) * c.height;
  double sum = 0;
  const double binder = r.uniform() < 0.5 ? 0 : r.uniform(0, std::max(0.0, 0.95 - fill));
  while (sum < area && seeds.size() < 700) {
    const double radius = std::max(7.0, sizes.draw(r));
    CellSeed s{r.uniform(-20, c.width + 20), r.uniform(-20, c.height + 20), radius * radius,
               r.uniform() < binder};
    sum += 3.0 * radius * radius;
    seeds.push_back(s);
  }
  return seeds;
}

// A power diagram with grooves of binder between its cells; some cells are binder.
void grow_cells(Canvas& c, double fill, const Sizes& sizes, Random& r, const Work& work) {
  const double area = static_cast<double>(c.width) * c.height;
  const std::vector<CellSeed> seeds = draw_seeds(c, fill, sizes, r);
  const double mean_radius = std::sqrt(area / (3.14 * seeds.size()));
  const double gap =
      fill > 0.93 && r.uniform() < 0.6 ? 0 : mean_radius * 2 * (1 - std::sqrt(std::min(0.98, fill)));
  const double warp = r.uniform() < 0.6 ? r.uniform(0, 5) : 0, warp_size = r.uniform(8, 50);
  const double uneven = r.uniform(0, 0.8);
  const std::uint64_t seed = r.bits();
  visit_cells(c, seeds, {warp, warp_size, seed}, work, [&](const CellPlace& p) {
    const double groove = gap * (1 + uneven * noise(seed + 8, Vec3(p.x, p.y, 0) / 30)) / 2;
    if (!seeds[p.first].binder && (gap == 0 || p.to_border > groove))
      c.id[c.at(p.x, p.y)] = static_cast<std::int32_t>(p.first) + 1;
  });
  c.particles = seeds.size();
}

// Light or dark lines that polishing left.
void scratch(Canvas& c, Random& r) {
  for (int lines = 1 + static_cast<int>(r.below(8)); lines > 0; --lines) {
    const double angle = r.uniform(0, 3.1416), cosine = std::cos(angle), sine = std::sin(angle),
                 offset = r.uniform(-0.5, 0.5) * std::hypot(c.width, c.height), width = r.uniform(0.7, 2.5),
                 gain = (r.uniform() < 0.5 ? -1 : 1) * r.uniform(0.03, 0.35);
    const std::uint64_t seed = r.bits();
    for (int y = 0; y < c.height; ++y)
      for (int x = 0; x < c.width; ++x) {
        const double u = x - 0.5 * c.width, v = y - 0.5 * c.height;
        const double away = std::abs(cosine * u + sine * v - offset) / width;
        if (away > 2) continue;
        const double fading =
            std::clamp(0.3 + 1.5 * noise(seed, Vec3(sine * u - cosine * v, 0, 0) / 80), 0.0, 1.0);
        c.color[c.at(x, y)] *= static_cast<float>(1 + gain * fading * std::exp(-away * away));
      }
  }
}

// Around particles the binder is lighter or darker, as edges are in an electron microscope; most in narrow
// bays.
void add_halo(Canvas& c, Random& r) {
  const double amount = (r.uniform() < 0.75 ? 1 : -1) * r.uniform(0.08, 0.6), sigma = r.uniform(2.5, 14);
  const bool in_particles = r.uniform() < 0.3;
  std::vector<float> near(c.id.size());
  for (std::size_t i = 0; i < near.size(); ++i) near[i] = c.id[i] > 0;
  blur(near, c.width, c.height, sigma);
  for (std::size_t i = 0; i < near.size(); ++i) {
    const double other = c.id[i] > 0 ? (in_particles ? 1 - near[i] : 0) : near[i];
    c.color[i] *= static_cast<float>(1 + amount * other);
  }
}

// Both return the size of a typical particle in canvas pixels.
double drop_or_grow(Canvas& c, const SectionOptions& options, Random& r, const Work& work) {
  const double fill = options.fill;
  const bool grown = options.kind == SectionKind::Grown;
  const Sizes sizes(r, std::sqrt(static_cast<double>(c.width) * c.height));
  const bool cells = !grown && (fill > 0.62 || (fill > 0.35 && r.uniform() < 0.3));
  if (cells)
    grow_cells(c, fill, sizes, r, work);
  else
    drop_shapes(c, fill, sizes, Family(r, grown), 0, r, work);
  if (!cells && r.uniform() < (grown ? 0.5 : 0.15))
    drop_shapes(c, r.uniform(0.01, 0.08), Sizes::fine(r), Family(r, false), r.uniform(2, 5), r, work);
  return sizes.middle();
}

double grow_joined(Canvas& c, double fill, Random& r, const Work& work) {
  const double cell = grow_together(c, fill, r, work);
  if (r.uniform() < 0.3) return cell;
  Family shapes(r, false);
  if (r.uniform() < 0.7) shapes.make_round();
  drop_shapes(c, r.uniform(0.01, 0.06), Sizes::fine(r, std::max(1.0, cell / 70)), shapes,
              r.uniform(2, 0.06 * cell), r, work);
  return cell;
}

}  // namespace

void make_plane_section(Canvas& c, const SectionOptions& options, const PhotoPalette& palette, Random& r,
                        const Work& work) {
  const bool joined = options.kind == SectionKind::Joined, grown = options.kind != SectionKind::Mixed;
  const double size = joined ? grow_joined(c, options.fill, r, work) : drop_or_grow(c, options, r, work);

  const Texture binder = palette.ground(r);
  std::vector<Texture> textures;
  for (int i = 0; i < c.particles; ++i) textures.push_back(palette.particle(r, size));
  // Polishing leaves hard grains higher; a microscope shows bright or dark rims.
  const double rise = r.uniform() < 0.3 ? r.uniform(0, 3) : 0;
  const double rim = r.uniform() < 0.25 ? r.uniform(-0.5, 0.5) : 0;
  std::vector<float> inner(c.id.size());
  for (std::size_t i = 0; i < c.id.size(); ++i) inner[i] = c.id[i] > 0;
  std::vector<float> wide = inner;
  blur(inner, c.width, c.height, 1.2);
  if (rim != 0) blur(wide, c.width, c.height, 3);
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      const std::size_t i = c.at(x, y);
      const int id = c.id[i];
      const Vec3 p(x, y, 0);
      Vec3f color = id > 0 ? textures[id - 1](p + Vec3(0, 0, 57.0 * id)) : binder(p);
      if (rim != 0) color *= static_cast<float>(1 + rim * 4 * wide[i] * (1 - wide[i]));
      c.color[i] = color;
      c.z[i] = static_cast<float>(rise) * inner[i];
    }
  if (joined) add_ghosts(c, size, r);
  if (r.uniform() < (joined ? 0.9 : grown ? 0.6 : 0.15)) add_halo(c, r);
  if (r.uniform() < (grown ? 0.4 : 0.1)) scratch(c, r);
  // Pores: dark pits that belong to no particle. Between fine dark particles nobody could tell them.
  if (r.uniform() < (grown ? 0.1 : 0.35))
    for (int pores = r.below(60); pores > 0; --pores) {
      const double px = r.uniform(0, c.width), py = r.uniform(0, c.height), radius = r.uniform(1, 7);
      const float shade = r.uniform(0.05, 0.5);
      for (int y = std::max<int>(0, py - radius); y <= std::min<double>(c.height - 1, py + radius); ++y)
        for (int x = std::max<int>(0, px - radius); x <= std::min<double>(c.width - 1, px + radius); ++x)
          if (std::hypot(x - px, y - py) < radius) c.color[c.at(x, y)] *= shade;
    }
}

}  // namespace terrazzo::synthetic_photo
