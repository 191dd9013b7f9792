#include "nodes/packing/rigid/placement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/directions.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/packing/rigid/spatial_order.h"
#include "runtime/random.h"

namespace terrazzo::packing {
namespace {

constexpr std::uint64_t kPlace = 0x706c616365, kBlock = 0x626c6f636b, kCenter = 0x63656e746572;
constexpr int kBlocks = 16;  // blocks along an edge, if balls are placed block by block
constexpr int kTries = 24;
constexpr double kMostCenters = 1e6;

int octave_of(double radius, double largest) {
  return static_cast<int>(std::clamp(std::log2(largest / radius), 0.0, 12.0));
}

double volume_of_ball(double radius) { return 4.0 / 3 * std::numbers::pi * radius * radius * radius; }

Vec3 uniform_in(const Vec3& low, const Vec3& edges, Random& random) {
  return Vec3(low[0] + random.uniform() * edges[0], low[1] + random.uniform() * edges[1],
              low[2] + random.uniform() * edges[2]);
}

Vec3 normal_about(const Vec3& center, double spread, const Vec3& box, Random& random) {
  const double x = random.normal(), y = random.normal();
  return wrap_point(center + spread * Vec3(x, y, random.normal()), box);
}

// The balls placed so far, in one grid per octave of radius.
class Occupied {
 public:
  Occupied(const Vec3& box, double largest) : box_(box), largest_(largest) {}

  void add(const Vec3& p, double radius) {
    Level& level = at(radius);
    level.balls[level.cells.at(p)].push_back({p, radius});
  }

  // Deepest overlap of a ball at p, relative to the smaller radius. Stops once it reaches `enough`.
  double overlap(const Vec3& p, double radius, double enough) const {
    double worst = 0;
    for (const Level& level : levels_) {
      if (level.balls.empty()) continue;
      level.cells.visit(p, radius + level.largest, [&](std::size_t cell) {
        for (const Ball& ball : level.balls[cell]) {
          if (worst >= enough) return;
          const double depth = radius + ball.radius - nearest_image(ball.p - p, box_).norm();
          if (depth > 0) worst = std::max(worst, depth / std::min(radius, ball.radius));
        }
      });
      if (worst >= enough) return worst;
    }
    return worst;
  }

 private:
  struct Ball {
    Vec3 p;
    double radius;
  };
  struct Level {
    double largest = 0;
    PeriodicCells cells;
    std::vector<std::vector<Ball>> balls;
  };
  Vec3 box_;
  double largest_;
  std::vector<Level> levels_;

  Level& at(double radius) {
    const std::size_t octave = octave_of(radius, largest_);
    if (levels_.size() <= octave) levels_.resize(octave + 1);
    Level& level = levels_[octave];
    if (level.balls.empty()) {
      level.largest = largest_ / std::exp2(static_cast<double>(octave));
      level.cells = PeriodicCells(box_, 2 * level.largest, 160);
      level.balls.resize(level.cells.count());
    }
    return level;
  }
};

// The order in which particles are placed, and the block of the box in which each is placed: by octave of
// size, then by block, so that the balls tested are in the cache.
struct Draw {
  std::uint32_t block;
  std::int32_t particle;
};
std::vector<Draw> draws(std::size_t first, const std::vector<double>& radius, double largest,
                        std::uint64_t seed) {
  std::vector<std::pair<std::uint64_t, std::int32_t>> order;
  for (std::size_t i = first; i < radius.size(); ++i) {
    const auto block = Random(seed, kBlock, i).below(kBlocks * kBlocks * kBlocks);
    order.emplace_back(static_cast<std::uint64_t>(octave_of(radius[i], largest)) << 32 | block,
                       static_cast<std::int32_t>(i));
  }
  std::sort(order.begin(), order.end());
  std::vector<Draw> out;
  for (const auto& [key, i] : order) out.push_back({static_cast<std::uint32_t>(key), i});
  return out;
}

// Centers of clusters, where a ball of a cluster's spread overlaps the balls placed so far the least.
std::vector<Vec3> centers_of(const Clusters& clusters, const Occupied& occupied, const Vec3& box, double free,
                             std::uint64_t seed, const Work& work) {
  const double many = std::min(kMostCenters, std::round(clusters.per_volume() * free));
  std::vector<Vec3> centers(static_cast<std::size_t>(std::max(1.0, many)));
  for (std::size_t i = 0; i < centers.size(); ++i) {
    if (i % 64 == 0) work.check();
    Random random(seed, kCenter, i);
    double least = 1e300;
    for (int t = 0; t < kTries && least > 0; ++t) {
      const Vec3 p(random.uniform() * box[0], random.uniform() * box[1], random.uniform() * box[2]);
      const double o = occupied.overlap(p, clusters.spread, least);
      if (o >= least) continue;
      least = o;
      centers[i] = p;
    }
  }
  return centers;
}

}  // namespace

void place_at_random(Packing& packing, std::size_t first, const std::vector<double>& radius,
                     std::uint64_t seed, const Work& work, const Clusters& clusters) {
  const std::size_t n = packing.count();
  if (n == 0) return;
  Occupied occupied(packing.box, *std::max_element(radius.begin(), radius.end()));
  for (std::size_t i = 0; i < first; ++i) occupied.add(packing.position[i], radius[i]);
  double free = packing.box.prod();  // that the particles placed so far leave
  for (std::size_t i = 0; i < first; ++i) free -= volume_of_ball(radius[i]);
  std::vector<Vec3> centers;
  int tries = kTries;  // fewer as the box fills and free positions become rare
  double crowded = 0;
  const bool by_block = n - first >= kCached;
  const auto order = by_block ? draws(first, radius, *std::max_element(radius.begin(), radius.end()), seed)
                              : std::vector<Draw>{};
  for (std::size_t k = first; k < n; ++k) {
    if (k % 256 == 0) work.check();
    const std::size_t i = by_block ? static_cast<std::size_t>(order[k - first].particle) : k;
    Vec3 low = Vec3::Zero(), edges = packing.box;
    if (by_block) {
      const std::uint32_t b = order[k - first].block;
      edges /= kBlocks;
      low = edges.cwiseProduct(Vec3(b % kBlocks, b / kBlocks % kBlocks, b / (kBlocks * kBlocks)));
    }
    Random random(seed, kPlace, i);
    const bool clustered = packing.size[i] < clusters.below;
    if (clustered && centers.empty()) centers = centers_of(clusters, occupied, packing.box, free, seed, work);
    const Vec3 center = clustered ? centers[random.below(centers.size())] : Vec3::Zero();
    double least = 1e300;
    int t = 0;
    for (; t < tries && least > 0; ++t) {
      const Vec3 p = clustered ? normal_about(center, clusters.spread, packing.box, random)
                               : uniform_in(low, edges, random);
      const double o = occupied.overlap(p, radius[i], least);
      if (o < least) {
        least = o;
        packing.position[i] = p;
      }
    }
    crowded = 0.98 * crowded + 0.02 * (least > 0);
    tries = crowded > 0.5 ? 8 : kTries;
    const Quat q = random_quaternion(random);
    packing.orientation[i] = q.norm() > 1e-9 ? q.normalized() : Quat::Identity();
    occupied.add(packing.position[i], radius[i]);
    free -= volume_of_ball(radius[i]);
  }
}

}  // namespace terrazzo::packing
