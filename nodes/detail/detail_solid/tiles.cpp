#include "nodes/detail/detail_solid/tiles.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/texture/quantiles.h"
#include "nodes/data/indices.h"
#include "nodes/solids/synthesis/optimize_solid.h"

namespace terrazzo::detail_solid {
namespace {

constexpr std::size_t kLeastTexture = 256;  // of a texture
constexpr int kLeastSide = 16;              // pixels of an exemplar
constexpr float kLeastDeviation = 0.002f;   // half a step of 8 bits
constexpr float kZero = 1;                  // added to offsets, since colors are at least 0

struct Window {
  int section = 0, x = 0, y = 0, width = 0, height = 0;
};

// The window of at most `side` pixels square that holds most pixels of the phase.
Window best_window(const Phases& p, int phase, int side) {
  const int w = std::min(side, p.width), h = std::min(side, p.height);
  Window best;
  best.width = w;
  best.height = h;
  long most = -1;
  std::vector<long> sum(static_cast<std::size_t>(p.width + 1) * (p.height + 1), 0);
  const auto at = [&](int x, int y) -> long& { return sum[static_cast<std::size_t>(y) * (p.width + 1) + x]; };
  for (int s = 0; s < p.sections; ++s) {
    for (int y = 0; y < p.height; ++y)
      for (int x = 0; x < p.width; ++x)
        at(x + 1, y + 1) = at(x, y + 1) + at(x + 1, y) - at(x, y) +
                           (p.phase[s * p.plane() + pixel_at(x, y, p.width)] == phase);
    for (int y = 0; y + h <= p.height; y += 4)
      for (int x = 0; x + w <= p.width; x += 4) {
        const long n = at(x + w, y + h) - at(x, y + h) - at(x + w, y) + at(x, y);
        if (n > most) {
          most = n;
          best.section = s;
          best.x = x;
          best.y = y;
        }
      }
  }
  return best;
}

}  // namespace

PartialPicture phase_exemplar(const Phases& p, int phase, int side, std::uint64_t seed, const Work& work) {
  PartialPicture out;
  if (p.pixels[phase] < kLeastTexture) return out;
  Vec3 all = Vec3::Zero();
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] == phase) all += p.offset[i].cast<double>();
  all /= static_cast<double>(p.pixels[phase]);
  const Window window = best_window(p, phase, side);
  if (std::min(window.width, window.height) < kLeastSide) return out;
  out.width = window.width;
  out.height = window.height;
  Vec3 mean = Vec3::Zero();
  double count = 0;
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const std::size_t i =
          window.section * p.plane() + static_cast<std::size_t>(window.y + y) * p.width + window.x + x;
      const bool known = p.phase[i] == phase;
      out.known.push_back(known);
      out.value.push_back(known ? p.offset[i] : Vec3f::Zero());
      if (known) {
        mean += p.offset[i].cast<double>();
        ++count;
      }
    }
  const auto shift = (all - mean / std::max(count, 1.0)).cast<float>();
  for (std::size_t i = 0; i < out.value.size(); ++i)
    if (out.known[i]) out.value[i] += shift;
  fill_picture(out, seed, work);
  return out;
}

void match_phase(std::vector<Vec3f>& tile, const Phases& p, const std::vector<Vec3f>& offset, int phase,
                 const Work& work) {
  if (p.pixels[phase] < kLeastTexture) return;
  std::vector<Vec3f> values;
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] == phase) {
      values.push_back(offset[i]);
      mean += offset[i].cast<double>();
    }
  mean /= static_cast<double>(values.size());
  Mat3 covariance = Mat3::Zero();
  for (const Vec3f& v : values) {
    const Vec3 d = v.cast<double>() - mean;
    covariance += d * d.transpose();
  }
  const Eigen::Matrix3f axes = eigen_axes(covariance).eigenvectors().cast<float>();
  std::vector<float> of_tile(tile.size()), of_phase(values.size());
  std::vector<Vec3f> out(tile.size(), Vec3f::Zero());
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < tile.size(); ++i) of_tile[i] = axes.col(c).dot(tile[i]);
    for (std::size_t i = 0; i < values.size(); ++i) of_phase[i] = axes.col(c).dot(values[i]);
    match_values(of_tile, quantiles_of(of_phase), work.quiet());
    for (std::size_t i = 0; i < tile.size(); ++i) out[i] += of_tile[i] * axes.col(c);
  }
  tile = std::move(out);
}

std::vector<Vec3f> phase_tile(const PartialPicture& exemplar, int size, std::uint64_t seed,
                              const Work& work) {
  const std::size_t voxels = static_cast<std::size_t>(size) * size * size;
  if (exemplar.value.empty()) return std::vector<Vec3f>(voxels, Vec3f::Zero());
  Vec3 mean = Vec3::Zero();
  for (const Vec3f& v : exemplar.value) mean += v.cast<double>();
  mean /= static_cast<double>(exemplar.value.size());
  double variance = 0;
  for (const Vec3f& v : exemplar.value) variance += (v.cast<double>() - mean).squaredNorm();
  variance /= exemplar.value.size();
  if (std::sqrt(variance) < kLeastDeviation) return std::vector<Vec3f>(voxels, mean.cast<float>());
  solids::SolidExemplar e;
  e.width = exemplar.width;
  e.height = exemplar.height;
  for (int y = e.height - 1; y >= 0; --y)
    for (int x = 0; x < e.width; ++x)
      e.pixels.push_back(exemplar.value[pixel_at(x, y, e.width)].array() + kZero);
  solids::SolidOptions settings;
  settings.size = Vec3i::Constant(size);
  settings.color = solids::SolidColor::Linear;
  settings.levels = 2;  // the broad part is left out
  settings.iterations = {8, 3};
  settings.seed = seed;
  settings.measured = false;
  const solids::SolidResult r = solids::optimize_solid({e}, settings, work);
  std::vector<Vec3f> out(voxels);
  for (std::size_t i = 0; i < voxels; ++i) {
    Vec3f v = Vec3f::Zero();
    for (int c = 0; c < r.axes.channels; ++c) v[c] = r.field.channel[c][i];
    out[i] = r.axes.from(v).array() - kZero;
  }
  return out;
}

}  // namespace terrazzo::detail_solid
