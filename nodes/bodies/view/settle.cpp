#include "nodes/bodies/view/settle.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/bodies/view/footprint.h"
#include "nodes/data/indices.h"

namespace terrazzo::view {
namespace {

using Meshes = std::vector<carving::RayScene::Triangles>;
using Stones = std::vector<carving::RayScene::Instance>;

constexpr double kMostCells = 4 << 20;     // of the map: 16 MiB, finer than a screen shows
constexpr double kMostCovered = 32 << 20;  // cells under all stones that may move, whose ceilings are kept
constexpr double kCoarser = 1.1;           // cells grow by this until they are few enough
constexpr double kMostExtent = 1e15;       // mm, as for rays
constexpr double kFirstStep = 1.0 / 8;     // diameters; longer ones jump over ridges
constexpr int kMostSteps = 96;             // enough to roll kFarthest and to find the lowest cell
constexpr int kMostSamples = 48;           // per side of a footprint, for a first look
constexpr std::size_t kReportEvery = 256;  // stones

// Radius in mm of the sphere around each stone's origin that holds it.
std::vector<double> radii_of(const Meshes& meshes, const Stones& stones) {
  std::vector<double> of_mesh;
  for (const carving::RayScene::Triangles& mesh : meshes) {
    double most = 0;
    for (const Vec3f& p : mesh.positions) most = std::max(most, p.cast<double>().norm());
    of_mesh.push_back(most);
  }
  std::vector<double> radii;
  for (const carving::RayScene::Instance& stone : stones)
    radii.push_back(of_mesh[stone.mesh] * stone.linear.col(0).cast<double>().norm());
  return radii;
}

CellGrid grid_with(const SettleOptions& options, double cell) {
  CellGrid grid;
  grid.cell = cell;
  grid.margin = round_up(options.largest / cell);
  grid.width = std::max(1, round_nearest(options.picture.x() / cell)) + 2 * grid.margin;
  grid.height = std::max(1, round_nearest(options.picture.y() / cell)) + 2 * grid.margin;
  return grid;
}

CellGrid grid_for(const Stones& stones, const std::vector<double>& radii, const SettleOptions& options) {
  const Vec2 size = options.picture + Vec2::Constant(2 * options.largest);
  if (!(size.maxCoeff() <= kMostExtent))
    throw Error("bad-number", "the picture or the largest stone exceeds 1e15 mm",
                "check width, height and the sizes of the stones");
  double covered = 0;  // mm²
  for (std::size_t i = 0; i < stones.size(); ++i)
    if (stones[i].offset.z() >= options.level) covered += 4 * radii[i] * radii[i];
  double cell = std::max({options.cell, std::sqrt(size.x() / kMostCells) * std::sqrt(size.y()),
                          std::sqrt(covered / kMostCovered), size.maxCoeff() / kMostCells});
  CellGrid grid = grid_with(options, cell);
  while (pixels_in(grid.width, grid.height) > kMostCells) {
    cell *= kCoarser;
    grid = grid_with(options, cell);
  }
  return grid;
}

// The cells around a stone's sphere.
Cells around(const carving::RayScene::Instance& stone, double radius, const CellGrid& grid) {
  const double reach = radius / grid.cell;
  Cells c;
  c.x = round_down(grid.column(stone.offset.x()) - reach);
  c.y = round_down(grid.row(stone.offset.y()) - reach);
  c.width = round_up(2 * reach) + 1;
  c.height = c.width;
  return c.within(grid);
}

// Adds a stone to a map unless it is wholly below.
void lay_visible(CellMap& map, const CellGrid& grid, const Meshes& meshes,
                 const carving::RayScene::Instance& stone, double radius) {
  const Cells c = around(stone, radius, grid);
  if (map.block(c.x, c.y, c.width, c.height).minCoeff() >= stone.offset.z() + radius) return;
  lay(map, grid, footprint_of(meshes[stone.mesh], stone, grid), stone.offset.z());
}

// The stones above or below the map, from the lowest center to the highest.
std::vector<std::size_t> upwards_in(const Stones& stones, const std::vector<double>& radii,
                                    const CellGrid& grid) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < stones.size(); ++i)
    if (!around(stones[i], radii[i], grid).empty()) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return stones[a].offset.z() < stones[b].offset.z(); });
  return order;
}

// A place of a stone: cells from where it was, and the height of its origin, mm.
struct Place {
  int dx = 0, dy = 0;
  float z = 0;
};

// Stones settle in the order of their centers: of two balls that don't overlap, the one whose center is
// higher is above the other wherever they cover the same cell, so each falls only onto settled ones.
class Settling {
 public:
  Settling(const Meshes& meshes, Stones& stones, const SettleOptions& options)
      : meshes_(meshes), stones_(stones), options_(options), radii_(radii_of(meshes, stones)) {
    grid_ = grid_for(stones, radii_, options);
    const float lowest =
        options.soil ? *options.soil - kBuried * static_cast<float>(options.largest) : options.deepest;
    ground_ = CellMap::Constant(grid_.width, grid_.height, std::max(lowest, options.deepest));
    ceiling_ = CellMap::Constant(grid_.width, grid_.height, std::numeric_limits<float>::infinity());
  }
  void run(const Work&);

 private:
  Footprint footprint(std::size_t stone) const {
    return footprint_of(meshes_[stones_[stone].mesh], stones_[stone], grid_);
  }
  void hang(const Footprint&, float z);
  void take_down(const Footprint&);
  void move(const Footprint&, carving::RayScene::Instance&, const Work&);
  float lowest_origin(const Footprint&) const;
  float rest_height(const Footprint&, const Place&, int stride) const;
  bool reachable(const Footprint&, const Place&) const;
  bool meets_ceiling(const Footprint&, const Place&) const;
  Place downhill(const Footprint&, const Place&, int step) const;
  Place place_of_rest(const Footprint&, float z, const Work&) const;

  const Meshes& meshes_;
  Stones& stones_;
  const SettleOptions& options_;
  std::vector<double> radii_;
  CellGrid grid_;
  CellMap ground_;                 // highest surface of what has settled
  CellMap ceiling_;                // lowest surface of what has not
  std::vector<CellMap> replaced_;  // by each stone that hangs in the ceiling, the lowest last
};

void Settling::run(const Work& work) {
  const std::vector<std::size_t> order = upwards_in(stones_, radii_, grid_);
  const auto stays = [&](std::size_t i) { return stones_[i].offset.z() < options_.level; };
  const std::size_t first = std::partition_point(order.begin(), order.end(), stays) - order.begin();
  for (std::size_t k = first; k-- > 0;) {  // downwards, since higher stones hide lower ones
    work.check();
    lay_visible(ground_, grid_, meshes_, stones_[order[k]], radii_[order[k]]);
  }
  for (std::size_t k = order.size(); k-- > first;) {
    work.check();
    hang(footprint(order[k]), stones_[order[k]].offset.z());
  }
  for (std::size_t k = first; k < order.size(); ++k) {
    work.check();
    if (k % kReportEvery == 0) work.done(k, order.size());
    const Footprint f = footprint(order[k]);
    take_down(f);
    move(f, stones_[order[k]], work);
  }
}

void Settling::hang(const Footprint& f, float z) {
  const Cells c = f.cells.within(grid_);
  if (c.empty()) {
    replaced_.emplace_back();
    return;
  }
  auto ceiling = ceiling_.block(c.x, c.y, c.width, c.height);
  replaced_.emplace_back(ceiling);
  ceiling = ceiling.min(f.low.block(c.x - f.cells.x, c.y - f.cells.y, c.width, c.height) + z);
}

// Undoes the last hang.
void Settling::take_down(const Footprint& f) {
  const Cells c = f.cells.within(grid_);
  if (!c.empty()) ceiling_.block(c.x, c.y, c.width, c.height) = replaced_.back();
  replaced_.pop_back();
}

void Settling::move(const Footprint& f, carving::RayScene::Instance& stone, const Work& work) {
  Place place{0, 0, stone.offset.z()};
  if (reachable(f, place)) place = place_of_rest(f, place.z, work);
  Footprint moved = f;
  moved.cells.x += place.dx;
  moved.cells.y += place.dy;
  lay(ground_, grid_, moved, place.z);
  const Vec2 shift = grid_.cell * Vec2(place.dx, place.dy);
  stone.offset.head<2>() += shift.cast<float>();
  stone.offset.z() = place.z;
}

// The height of the origin at which the stone lies on the bottom, or in soil.
float Settling::lowest_origin(const Footprint& f) const {
  const float on_bottom = options_.deepest - f.bottom;
  return options_.soil ? std::max(on_bottom, *options_.soil - kBuried * f.height() - f.bottom) : on_bottom;
}

// The height of the origin at which the stone touches what has settled. With a stride above 1 it is sampled
// at every so many cells in x and y, and so is at most the true one.
float Settling::rest_height(const Footprint& f, const Place& place, int stride) const {
  const int x = f.cells.x + place.dx;
  const int y = f.cells.y + place.dy;
  const float least = lowest_origin(f);
  if (stride == 1)
    return std::max(least, (ground_.block(x, y, f.cells.width, f.cells.height) - f.low).maxCoeff());
  const int across = (f.cells.width + stride - 1) / stride;
  const int upwards = (f.cells.height + stride - 1) / stride;
  const auto below = ground_(Eigen::seqN(x, across, stride), Eigen::seqN(y, upwards, stride));
  const auto low = f.low(Eigen::seqN(0, across, stride), Eigen::seqN(0, upwards, stride));
  return std::max(least, (below - low).maxCoeff());
}

// Whether the stone may roll to a place: not too far, and with all its cells in the map.
bool Settling::reachable(const Footprint& f, const Place& place) const {
  const double farthest = kFarthest * std::max(f.cells.width, f.cells.height);
  if (std::hypot(place.dx, place.dy) > farthest) return false;
  const int x = f.cells.x + place.dx;
  const int y = f.cells.y + place.dy;
  return x >= 0 && y >= 0 && x + f.cells.width <= grid_.width && y + f.cells.height <= grid_.height;
}

// A stone doesn't roll into or over others that have not settled yet.
bool Settling::meets_ceiling(const Footprint& f, const Place& place) const {
  const auto ceiling =
      ceiling_.block(f.cells.x + place.dx, f.cells.y + place.dy, f.cells.width, f.cells.height);
  return (f.high + place.z > ceiling).any();
}

// Of the eight places around one, that with the steepest way down, or that one if none is lower. A first look
// at few cells says which ones cannot be steeper; it decides nothing else, so large stones find the same
// place in less time.
Place Settling::downhill(const Footprint& f, const Place& place, int step) const {
  const int stride = (std::max(f.cells.width, f.cells.height) + kMostSamples - 1) / kMostSamples;
  Place best = place;
  float steepest = 0;  // mm per step
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u) {
      Place next{place.dx + u * step, place.dy + v * step, 0};
      if ((u == 0 && v == 0) || !reachable(f, next)) continue;
      const float length = u != 0 && v != 0 ? std::numbers::sqrt2_v<float> : 1;
      const float lower = place.z - steepest * length;
      next.z = rest_height(f, next, stride);
      if (stride > 1 && next.z < lower) next.z = rest_height(f, next, 1);
      if (!(next.z < lower) || meets_ceiling(f, next)) continue;
      best = next;
      steepest = (place.z - next.z) / length;
    }
  return best;
}

Place Settling::place_of_rest(const Footprint& f, float z, const Work& work) const {
  Place place{0, 0, z};
  place.z = std::min(z, rest_height(f, place, 1));
  const float least = lowest_origin(f);
  int step = std::max(1, round_down(kFirstStep * std::max(f.cells.width, f.cells.height)));
  for (int k = 0; k < kMostSteps && place.z > least; ++k) {
    work.check();
    const Place next = downhill(f, place, step);
    if (next.z < place.z)
      place = next;
    else if (step > 1)
      step /= 2;
    else
      break;
  }
  return place;
}

}  // namespace

float reach_below(const carving::RayScene::Triangles& mesh, const Eigen::Matrix3f& linear) {
  const Vec3f up = linear.row(2);
  float lowest = -std::numeric_limits<float>::min();
  for (const Vec3f& p : mesh.positions) lowest = std::min(lowest, up.dot(p));
  return -lowest;
}

float exposure_of_share(const Meshes& meshes, const Stones& stones, const std::vector<float>& exposures,
                        SettleOptions options, double share, const Work& work) {
  options.level = std::numeric_limits<float>::infinity();  // no ceilings are kept
  const std::vector<double> radii = radii_of(meshes, stones);
  const CellGrid grid = grid_for(stones, radii, options);
  std::vector<std::pair<float, std::size_t>> order;
  for (std::size_t i = 0; i < stones.size(); ++i)
    if (stones[i].offset.z() + radii[i] > 0 && !around(stones[i], radii[i], grid).empty())
      order.emplace_back(exposures[i], i);
  std::sort(order.begin(), order.end());
  const Cells picture{grid.margin, grid.margin, grid.width - 2 * grid.margin, grid.height - 2 * grid.margin};
  const auto wanted = std::llround(share * pixels_in(picture.width, picture.height));
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> covered =
      Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>::Constant(grid.width, grid.height, false);
  std::int64_t count = 0;  // of covered cells in the picture
  for (const auto& [exposure, i] : order) {
    work.check();
    const Cells near = around(stones[i], radii[i], grid);
    if (covered.block(near.x, near.y, near.width, near.height).all()) continue;
    const Footprint f = footprint_of(meshes[stones[i].mesh], stones[i], grid);
    const Cells c = f.cells.within(grid);
    for (int y = c.y; y < c.y + c.height; ++y)
      for (int x = c.x; x < c.x + c.width; ++x) {
        if (covered(x, y) || !(f.high(x - f.cells.x, y - f.cells.y) + stones[i].offset.z() > 0)) continue;
        covered(x, y) = true;
        count += picture.holds(x, y);
      }
    if (count > wanted) return exposure;
  }
  return order.empty() ? 0 : order.back().first;
}

void settle(const Meshes& meshes, Stones& stones, const SettleOptions& options, const Work& work) {
  Settling(meshes, stones, options).run(work);
}

}  // namespace terrazzo::view
