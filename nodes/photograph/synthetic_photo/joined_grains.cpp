#include "nodes/photograph/synthetic_photo/joined_grains.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/components.h"
#include "nodes/common/geometry/rank.h"
#include "nodes/common/texture/noise.h"
#include "nodes/photograph/synthetic_photo/cells.h"

namespace terrazzo::synthetic_photo {
namespace {

// Cells of about equal size: of a few places, the one farthest from the earlier seeds is taken.
std::vector<CellSeed> spread_seeds(const Canvas& c, double cell, double binder, Random& r) {
  const double area = (c.width + cell) * (c.height + cell);
  std::vector<CellSeed> seeds(static_cast<std::size_t>(std::clamp(area / (cell * cell), 4.0, 700.0)));
  for (std::size_t k = 0; k < seeds.size(); ++k) {
    double farthest = -1;
    for (int attempt = 0; attempt < 4; ++attempt) {
      const double x = r.uniform(-cell / 2, c.width + cell / 2),
                   y = r.uniform(-cell / 2, c.height + cell / 2);
      double nearest = 1e30;
      for (std::size_t n = 0; n < k; ++n)
        nearest = std::min(nearest, std::hypot(seeds[n].x - x, seeds[n].y - y));
      if (nearest <= farthest) continue;
      farthest = nearest;
      seeds[k].x = x;
      seeds[k].y = y;
    }
    const double size = cell * r.uniform(0, 0.6);
    seeds[k].weight = size * size;
    seeds[k].binder = r.uniform() < binder;
  }
  return seeds;
}

// Which cells grew together: numbers that joined cells share. Each cell joins some of its nearest neighbors,
// until the grain has `most` cells.
std::vector<std::size_t> join_cells(const std::vector<CellSeed>& seeds, double share, std::size_t most,
                                    Random& r) {
  constexpr std::size_t kNeighbors = 3;
  std::vector<std::size_t> grain(seeds.size()), order(seeds.size()), size(seeds.size(), 1);
  for (std::size_t k = 0; k < grain.size(); ++k) grain[k] = order[k] = k;
  for (std::size_t k = 0; k < seeds.size(); ++k) {
    const auto apart = [&](std::size_t n) {
      return std::hypot(seeds[n].x - seeds[k].x, seeds[n].y - seeds[k].y);
    };
    const std::size_t near = std::min(kNeighbors + 1, order.size());  // the first is the cell itself
    std::partial_sort(order.begin(), order.begin() + near, order.end(),
                      [&](std::size_t a, std::size_t b) { return apart(a) < apart(b); });
    for (std::size_t n = 1; n < near; ++n) {
      const std::size_t mine = grain[k], other = grain[order[n]];
      if (r.uniform() >= share || mine == other || size[mine] + size[other] > most) continue;
      std::replace(grain.begin(), grain.end(), other, mine);
      size[mine] += size[other];
    }
  }
  return grain;
}

struct Growth {
  double cell, gap, uneven;
  std::vector<std::size_t> grain;
  std::uint64_t seed;

  // Half of the channel's width at a place; negative where the two cells have grown together.
  double channel(const CellPlace& p) const {
    const double wave = noise(seed, Vec3(p.x, p.y, 0) / (0.7 * cell));
    return gap / 2 * (grain[p.first] == grain[p.second] ? std::min(1.0, 4 * wave - 0.8) : 1 + uneven * wave);
  }
};

}  // namespace

double grow_together(Canvas& c, double fill, Random& r, const Work& work) {
  Growth g;
  g.cell = 40 * std::pow(4, r.uniform());
  g.gap = g.cell * r.uniform(0.12, 0.3);
  g.uneven = r.uniform(0, 0.6);
  g.seed = r.bits();
  const double open = std::pow(1 - g.gap / g.cell, 2);
  const std::vector<CellSeed> seeds = spread_seeds(c, g.cell, std::clamp(1 - fill / open, 0.0, 0.8), r);
  g.grain = join_cells(seeds, r.uniform(0.1, 0.9), 2 + r.below(6), r);
  const CellWarp warp{g.cell * r.uniform(0, 0.2), g.cell * r.uniform(0.25, 0.7), r.bits()};
  std::vector<float> inside(c.id.size(), 0);
  visit_cells(c, seeds, warp, work, [&](const CellPlace& p) {
    if (seeds[p.first].binder) return;
    inside[c.at(p.x, p.y)] = seeds[p.second].binder || p.to_border > g.channel(p);
  });
  // Corners become round; channels stay open, since they are wider than the blur.
  blur(inside, c.width, c.height, std::min(g.cell * r.uniform(0.06, 0.18), 0.6 * g.gap));
  std::vector<float> sorted = inside;
  const float level =
      at_rank(sorted, static_cast<std::size_t>((1 - std::min(fill, 1.0)) * (sorted.size() - 1)));
  std::vector<std::int32_t> raster(inside.size());
  for (std::size_t i = 0; i < raster.size(); ++i) raster[i] = inside[i] > std::clamp(level, 0.3f, 0.7f);
  Components grains = connected_components(raster, c.width, c.height, false);
  const double least = 0.02 * g.cell * g.cell;
  for (auto& id : grains.ids)
    if (id > 0 && grains.sizes[id - 1] < least) id = 0;
  renumber_labels(grains.ids);
  c.id = std::move(grains.ids);
  c.particles = *std::max_element(c.id.begin(), c.id.end());
  return g.cell;
}

void add_ghosts(Canvas& c, double cell, Random& r) {
  for (int ghosts = static_cast<int>(r.below(12)); ghosts > 0; --ghosts) {
    const double px = r.uniform(0, c.width), py = r.uniform(0, c.height),
                 radius = cell * 0.05 * std::pow(12, r.uniform()), soft = radius * r.uniform(0.3, 0.9),
                 longer = r.uniform(1, 2.5), gain = (r.uniform() < 0.5 ? -1 : 1) * r.uniform(0.02, 0.08);
    const double reach = (radius + 3 * soft) * longer;
    for (int y = std::max<int>(0, py - reach); y <= std::min<double>(c.height - 1, py + reach); ++y)
      for (int x = std::max<int>(0, px - reach); x <= std::min<double>(c.width - 1, px + reach); ++x) {
        const double away = std::hypot((x - px) / longer, y - py);
        c.color[c.at(x, y)] *= static_cast<float>(1 + gain / (1 + std::exp(4 * (away - radius) / soft)));
      }
  }
}

}  // namespace terrazzo::synthetic_photo
