#include "nodes/detail/residual/residual_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/floor_of.h"
#include "nodes/common/geometry/periodic.h"
#include "nodes/common/geometry/tile_fit.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/detail.h"
#include "nodes/data/indices.h"
#include "nodes/data/particles.h"
#include "nodes/data/volume.h"
#include "runtime/random.h"

namespace terrazzo::residual {
namespace {

constexpr std::uint64_t kParticleStream = 0x72657331, kBinderStream = 0x72657332, kLayerStream = 0x72657333,
                        kTurnStream = 0x72657334, kCellStream = 0x72657335, kSeedStream = 0x72657336,
                        kSlopeStream = 0x72657337;
constexpr float kUnknown = 1e8f;  // mm: distances from outlines that nobody measured are larger
constexpr float kCell = 0.7f;     // edge of the binder's cells, in tiles
// Differences in Oklab and in the logarithm of the size that count equally.
constexpr float kColorSpread = 0.03f, kSizeSpread = 0.5f;
constexpr float kSteepest = 1;  // limit of what slopes add, in their standard deviations
constexpr float kBlend = 10;    // width in voxels over which cells blend

// Gradient noise with `cells` lattice steps per period; about −1 to 1.
float periodic_noise(const Vec3f& p, const Vec3i& cells) {
  int at[3];
  float f[3], u[3];
  for (int k = 0; k < 3; ++k) {
    at[k] = floor_of(p[k]);
    f[k] = p[k] - at[k];
    u[k] = f[k] * f[k] * f[k] * (f[k] * (f[k] * 6 - 15) + 10);
  }
  float sum = 0;
  for (int c = 0; c < 8; ++c) {
    const int d[3] = {c & 1, c >> 1 & 1, c >> 2};
    std::uint64_t item = 0;
    float w = 1;
    for (int k = 0; k < 3; ++k) {
      item = item * 65537 + wrap_index(at[k] + d[k], cells[k]);
      w *= d[k] ? u[k] : 1 - u[k];
    }
    const std::uint64_t h = Random(1, kLayerStream, item).bits();
    const auto side = [&](int bit) { return h >> bit & 1 ? 1.0f : -1.0f; };
    const int flat = (h >> 8) % 3;  // a gradient towards one of the twelve edges
    float g = 0;
    for (int k = 0; k < 3; ++k)
      if (k != flat) g += side(k) * (f[k] - d[k]);
    sum += w * g;
  }
  return sum;
}

// Almost `v` where it is small; between −limit and limit. Long particles and rare steep slopes would
// otherwise get black ends, and planes far from a center a color of their own.
float limited(float v, float limit) { return limit > 0 ? limit * std::tanh(v / limit) : 0; }

// One of the 24 rotations that map the axes to each other.
Eigen::Matrix3f cube_turn(std::uint64_t which) {
  const int first = which % 6, second = which / 6 % 4;
  const int a = first / 2, b = (a + 1 + second / 2) % 3;
  Eigen::Matrix3f m = Eigen::Matrix3f::Zero();
  m(a, 0) = first % 2 ? -1.0f : 1.0f;
  m(b, 1) = second % 2 ? -1.0f : 1.0f;
  m.col(2) = m.col(0).cross(m.col(1));
  return m;
}

std::vector<Vec3f> values_of(const openvdb::Vec3SGrid& grid, const Vec3i& size, const Work& work) {
  const std::size_t nx = size.x(), ny = size.y(), nz = size.z();
  std::vector<Vec3f> values(nx * ny * nz);
  work.quiet().parallel(nz, 4, [&](std::size_t begin, std::size_t end) {
    auto accessor = grid.getConstAccessor();
    for (std::size_t k = begin; k < end; ++k)
      for (std::size_t j = 0; j < ny; ++j)
        for (std::size_t i = 0; i < nx; ++i) {
          const auto& v = accessor.getValue({static_cast<int>(i), static_cast<int>(j), static_cast<int>(k)});
          values[(k * ny + j) * nx + i] = {v[0], v[1], v[2]};
        }
  });
  if (std::any_of(values.begin(), values.end(), [](const Vec3f& v) { return !v.allFinite(); }))
    throw Error("bad-residual", "the residual contains NaN or infinity");
  return values;
}

}  // namespace

void ResidualField::add_tile(std::vector<Vec3f> values, const Vec3i& size, double footprint, Keep keep,
                             const Work& work) {
  if (footprint > 1) widen_footprint(values, size, footprint, work.quiet());
  Vec3 sum = Vec3::Zero();
  for (const Vec3f& v : values) sum += v.cast<double>();
  const auto mean = (sum / static_cast<double>(values.size())).cast<float>();
  Tile tile;
  tile.spline = SplineTile(std::move(values), size, keep, work.quiet());
  tile.mean = mean;
  tiles_.push_back(std::move(tile));
}

ResidualField::ResidualField(const Volume& volume, const Vec3& box, const Work& work)
    : box_(box.cast<float>()) {
  const auto grid = volume.find<openvdb::Vec3SGrid>("residual");
  if (!grid)
    throw Error("no-residual", "the volume at input 'detail' has no Vec3SGrid named 'residual'",
                "connect DetailSolid.detail or ResidualSynth.volume");
  const Vec3i size = volume.resolution;
  if (size.minCoeff() < 1)
    throw Error("bad-residual", "the residual is not periodic",
                "connect a periodic volume, for example from ResidualSynth");
  const double voxel = grid->transform().voxelSize()[0];
  if (!(voxel > 0) || !std::isfinite(voxel))
    throw Error("bad-residual", "the residual's voxel size is not positive");
  for (int a = 0; a < 3; ++a) {
    const TileFit fit = fit_tile(box[a], size[a] * voxel);
    periods_[a] = fit.periods;
    scale_[a] = fit.scale;
    voxels_per_mm_[a] = fit.periods * size[a] / box[a];
  }
  add_tile(values_of(*grid, size, work), size, 1, Keep::Values, work);
}

ResidualField::ResidualField(const Detail& detail, const Particles& particles, double footprint, Keep keep,
                             const Work& work)
    : box_(particles.box.cast<float>()),
      phases_(true),
      gray_(detail.gray),
      rims_per_mm_(static_cast<float>(1 / detail.pixel_size)) {
  if (detail.phases.empty() || detail.size < 1)
    throw Error("bad-detail", "the detail is empty", "connect DetailSolid.detail");
  voxels_per_mm_.setConstant(static_cast<float>(1 / detail.pixel_size));
  for (const Detail::Phase& phase : detail.phases) {
    const Vec3i size = Vec3i::Constant(detail.size);
    const double voxels = footprint / detail.pixel_size;
    std::vector<Vec3f> values = phase.tile, broad = phase.broad;
    const bool zones = !tiles_.empty() && !broad.empty();
    if (!zones)
      for (std::size_t i = 0; i < broad.size(); ++i) values[i] += broad[i];
    add_tile(std::move(values), size, voxels, keep, work);
    if (zones) {
      if (voxels > 1) widen_footprint(broad, size, voxels, work.quiet());
      tiles_.back().broad = SplineTile(std::move(broad), size, keep, work.quiet());
      tiles_.back().zones = true;
    }
    tiles_.back().rims = phase.rims;
    tiles_.back().gain = phase.gain;
    tiles_.back().grain_gain = phase.grain_gain;
    tiles_.back().limit = kSteepest * phase.slope;
    tiles_.back().tilt = phase.tilt;
  }
  if (zones_ = detail.zones; !zones_.level.empty()) {
    constexpr double kPixelBlur = 0.4;  // of an edge that is seen in whole pixels or voxels
    std::vector<float> sigma = zones_.sigma;
    for (float& s : sigma) s *= static_cast<float>(detail.pixel_size);
    waves_ = WaveField(sigma, zones_.variance, particles.box);
    softness_ = static_cast<float>(detail.softness * detail.pixel_size);
    const auto pixel = static_cast<float>(kPixelBlur * std::max(footprint, detail.pixel_size));
    sharp_edge_ = waves_.slope() * pixel;
    edge_ = waves_.slope() * std::max(softness_, pixel);
  }
  place_particles(detail, particles);
  place_cells(detail.size, detail.pixel_size);
}

void ResidualField::place_particles(const Detail& detail, const Particles& particles) {
  std::vector<Vec3f> colors;
  for (std::size_t g = 1; g < detail.phases.size(); ++g)
    colors.push_back(linear_to_oklab(detail.phases[g].color));
  std::vector<Vec3f> samples;
  for (const Vec3f& c : detail.profile_color) samples.push_back(linear_to_oklab(c));
  for (std::size_t p = 0; p < particles.count(); ++p) {
    const Vec3f color = linear_to_oklab(particles.color[p]);
    std::size_t best = 0;
    for (std::size_t g = 1; g < colors.size(); ++g)
      if ((colors[g] - color).squaredNorm() < (colors[best] - color).squaredNorm()) best = g;
    const float shown = kShownSize * static_cast<float>(particles.size[p]);
    shown_.push_back(shown);
    const auto unlike = [&](std::size_t k) {
      const float size = shown > 0 ? std::log(detail.profile_size[k] / shown) / kSizeSpread : 0;
      return (samples[k] - color).squaredNorm() / (kColorSpread * kColorSpread) + size * size;
    };
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < samples.size(); ++k)
      if (unlike(k) < unlike(nearest)) nearest = k;
    const Eigen::Vector2f own = samples.empty() ? Eigen::Vector2f(1, 1) : detail.profile_contrast[nearest];
    contrast_.push_back(own);
    broad_contrast_.push_back(nearest < detail.profile_broad.size() ? detail.profile_broad[nearest] : own);
    // Without groups, particles have no detail of their own; they show the binder's.
    // Contrasts are relative to the group of their profile.
    group_.push_back(nearest < detail.profile_group.size() ? detail.profile_group[nearest]
                     : colors.empty()                      ? 0
                                                           : static_cast<int>(best) + 1);
    Place place = random_place(kParticleStream, p, particles.position[p].cast<float>());
    Random random(1, kSlopeStream, p);
    const double radius = particles.size[p] / 2;
    if (radius > 0)
      for (int a = 0; a < 3; ++a)
        place.slope[a] =
            random.normal() * detail.phases[static_cast<std::size_t>(group_.back())].slope / radius;
    places_.push_back(place);
    // Without groups, offsets are the binder's.
    scales_.push_back(colors.empty() ? 1.0f : Detail::particle_scale(linear_to_srgb(particles.color[p])));
  }
}

void ResidualField::place_cells(int size, double voxel) {
  for (int a = 0; a < 3; ++a)
    cells_[a] = std::max(1, round_nearest(box_[a] / (kCell * static_cast<float>(size * voxel))));
  for (int z = 0; z < cells_.z(); ++z)
    for (int y = 0; y < cells_.y(); ++y)
      for (int x = 0; x < cells_.x(); ++x) {
        const std::uint64_t item = cell_.size();
        Random random(1, kSeedStream, item);
        Vec3f seed(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
        for (int a = 0; a < 3; ++a) seed[a] += static_cast<float>(random.uniform(0.15, 0.85));
        cell_.push_back(
            random_place(kCellStream, item, seed.cwiseQuotient(cells_.cast<float>()).cwiseProduct(box_)));
        centers_.push_back(cell_.back().center);
      }
}

// The center is moved to the nearest voxel of a lattice in the box's corner, so that a picture whose pixels
// lie on that lattice shows voxels as they are.
ResidualField::Place ResidualField::random_place(std::uint64_t stream, std::uint64_t item,
                                                 const Vec3f& center) const {
  Random random(1, stream, item), turns(1, kTurnStream ^ stream, item);
  Place place;
  place.turn = cube_turn(turns.below(24));
  for (int a = 0; a < 3; ++a) {
    place.center[a] = (std::floor(center[a] * voxels_per_mm_[a]) + 0.5f) / voxels_per_mm_[a];
    place.shift[a] = random.below(static_cast<std::uint64_t>(tiles_[0].spline.size()[a]));
  }
  return place;
}

Vec3f ResidualField::nearest_image(Vec3f offset) const {
  for (int a = 0; a < 3; ++a)
    if (std::abs(offset[a]) > 0.499f * box_[a])  // else the number of edges is 0
      offset[a] -= box_[a] * floor_of(offset[a] / box_[a] + 0.5f);
  return offset;
}

Vec3f ResidualField::in_tile(const Place& place, const Vec3f& mm) const {
  return place.turn * nearest_image(mm - place.center).cwiseProduct(voxels_per_mm_) + place.shift;
}

Vec3f ResidualField::moved(std::uint64_t stream, std::uint64_t item) const {
  Random random(1, stream, item);
  const float x = random.uniform(), y = random.uniform();
  return Vec3f(x, y, static_cast<float>(random.uniform())).cwiseProduct(box_);
}

// Cells are those of the nearest center. Where centers are almost equally near, their tiles are averaged with
// the deviation preserved.
Vec3f ResidualField::binder(const Vec3f& mm) const {
  int near[3][3], nears[3];  // along each axis: cells around the point's, without repetition, and how many
  for (int a = 0; a < 3; ++a) {
    const int home = floor_of(mm[a] / box_[a] * cells_[a]);
    nears[a] = std::min(cells_[a], 3);
    for (int k = 0; k < nears[a]; ++k) near[a][k] = wrap_index(home + k - 1, cells_[a]);
  }
  std::size_t index[27];
  float squared[27], least = 1e30f;
  int count = 0;
  for (int z = 0; z < nears[2]; ++z)
    for (int y = 0; y < nears[1]; ++y) {
      const std::size_t row = (static_cast<std::size_t>(near[2][z]) * cells_.y() + near[1][y]) * cells_.x();
      for (int x = 0; x < nears[0]; ++x, ++count) {
        index[count] = row + near[0][x];
        squared[count] = nearest_image(mm - centers_[index[count]]).squaredNorm();
        least = std::min(least, squared[count]);
      }
    }
  const float nearest = std::sqrt(least) * voxels_per_mm_.x();
  const float far = (nearest + 1.01f * kBlend) / voxels_per_mm_.x();
  const Tile& tile = tiles_[0];
  Vec3f sum = Vec3f::Zero();
  float squares = 0;
  for (int n = 0; n < count; ++n) {
    if (squared[n] > far * far) continue;  // clearly; spares the root
    float w = 1 - (std::sqrt(squared[n]) * voxels_per_mm_.x() - nearest) / kBlend;
    if (w <= 0) continue;
    w = w * w * (3 - 2 * w);
    sum += w * (tile.spline.at(in_tile(cell_[index[n]], mm)) - tile.mean);
    squares += w * w;
  }
  return tile.mean + sum / std::sqrt(squares);
}

float ResidualField::dark_share(const Vec3f& mm, float level, float edge) const {
  const float below = level - waves_.at(mm);
  return 0.5f * std::erfc(-below / (std::numbers::sqrt2_v<float> * edge));
}

float ResidualField::dark_zone(const Vec3f& mm, float width) const {
  return dark_share(mm, Detail::at_distance(zones_.level_by_width, width * rims_per_mm_), sharp_edge_);
}

Vec3f ResidualField::plain(const Vec3f& mm, int particle) const {
  const auto spline = [&](const Vec3f& at) {
    return tiles_[0].spline.at(at.cwiseProduct(voxels_per_mm_) - Vec3f::Constant(0.5f));
  };
  if (periods_.maxCoeff() == 1) return spline(mm);
  if (particle >= 0) return spline(mm + moved(kParticleStream, particle));
  // Layers about a third of a tile thick.
  const float layer =
      5 * periodic_noise(mm.cwiseQuotient(box_).cwiseProduct(periods_.cast<float>()), periods_) + 100;
  const int low = floor_of(layer);
  float t = std::clamp((layer - low - 0.3f) / 0.4f, 0.0f, 1.0f);
  t = t * t * (3 - 2 * t);
  const auto part = [&](int i) { return spline(mm + moved(kBinderStream, i)); };
  if (t <= 0) return part(low);
  if (t >= 1) return part(low + 1);
  return ((1 - t) * part(low) + t * part(low + 1)) / std::sqrt(t * t + (1 - t) * (1 - t));
}

Vec3f ResidualField::at(const Vec3f& mm, int particle, float depth, float size, float dark) const {
  if (!phases_) return plain(mm, particle);
  const Vec3f offset = by_phase(mm, particle, depth, size, dark);
  return gray_ ? Vec3f::Constant(offset.mean()) : offset;
}

float ResidualField::size_of(int particle, float size) const {
  return particle >= 0 && !(size > 0) && phases_ ? shown_[particle] : size;
}

Vec3f ResidualField::behind(const Vec3f& mm, int particle, float depth, float size, float dark) const {
  return at(mm, -1, depth, size_of(particle, size), dark);
}

Vec3f ResidualField::mixed(const Vec3f& mm, int particle, float cover, float depth, float size,
                           const Vec3f* binder, float dark) const {
  if (particle < 0) cover = 0;
  Vec3f offset = Vec3f::Zero();
  if (cover > 0) offset += cover * at(mm, particle, depth, size_of(particle, size));
  if (cover < 1) offset += (1 - cover) * (binder ? *binder : behind(mm, particle, depth, size, dark));
  return offset;
}

Vec3f ResidualField::light(const Vec3f& mm, int particle, float cover, float depth, float size,
                           const Eigen::Vector2f& normal, const Vec3f& right, const Vec3f& up) const {
  if (!phases_) return Vec3f::Zero();
  const float bins = depth * rims_per_mm_;
  if (particle < 0) cover = 0;
  const float known = size_of(particle, size);
  Vec3f sum = (1 - cover) * Detail::light_at(tiles_[0].rims, bins, known, normal);
  if (cover > 0) {
    const std::size_t p = particle;
    const Tile& tile = tiles_[group_[p]];
    Vec3f own = Detail::light_at(tile.rims, bins, known, normal);
    if (shown_[p] > 0) {
      const Vec3f across = nearest_image(mm - places_[p].center) / (shown_[p] / 2);
      const float limit = tile.tilt.norm();  // at the profile's edge
      own += Vec3f::Constant(limited(across.dot(tile.tilt.x() * right + tile.tilt.y() * up), limit));
    }
    sum += cover * scales_[p] * own;
  }
  return gray_ ? Vec3f::Constant(sum.mean()) : sum;
}

Vec3f ResidualField::by_phase(const Vec3f& mm, int particle, float depth, float size, float dark) const {
  const float bins = depth * rims_per_mm_;
  const std::size_t p = std::max(particle, 0);
  const Tile& tile = tiles_[particle < 0 ? 0 : group_[p]];
  const float gain = tile.gain.empty() ? 1 : Detail::at_distance(tile.gain, bins);
  const Vec3f rim = Detail::rim_at(tile.rims, bins, size);
  if (particle < 0 && has_zones()) {
    if (dark < 0)
      dark = dark_share(mm, depth < kUnknown ? Detail::at_distance(zones_.level, bins) : zones_.mean_level,
                        edge_);
    const float light = 1 - dark;
    return gain * (dark * zones_.dark_contrast + light * zones_.light_contrast) * binder(mm) + rim +
           dark * zones_.dark + light * zones_.light;
  }
  if (particle < 0) return gain * binder(mm) + rim;
  const float slope = limited(places_[p].slope.dot(nearest_image(mm - places_[p].center)), tile.limit);
  const auto scaled = [](const Vec3f& offset, const Eigen::Vector2f& contrast) {
    const Vec3f gray = Vec3f::Constant(offset.mean());
    return Vec3f(contrast.x() * gray + contrast.y() * (offset - gray));
  };
  const Vec3f at = in_tile(places_[p], mm);
  const float grain = tile.grain_gain.empty() ? 1 : Detail::at_distance(tile.grain_gain, bins);
  Vec3f offset = grain * scaled(tile.spline.at(at), contrast_[p]);
  if (tile.zones) offset += scaled(tile.broad.at(at), broad_contrast_[p]);
  return scales_[p] * (gain * offset + rim + Vec3f::Constant(slope));
}

}  // namespace terrazzo::residual
