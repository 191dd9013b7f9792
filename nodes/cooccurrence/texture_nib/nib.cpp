#include "nodes/cooccurrence/texture_nib/nib.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/footprint.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::texture_nib {
namespace {

using Eight = std::int32_t __attribute__((vector_size(32), aligned(4), may_alias));
using EightF = float __attribute__((vector_size(32), aligned(4), may_alias));
constexpr int kLanes = 8;

}  // namespace

Nib::Nib(Image picture, NibTexture texture, DabOptions dab_settings)
    : picture_(std::move(picture)), texture_(std::move(texture)), dab_settings_(dab_settings) {
  const int levels = texture_.levels.count();
  for (const auto& o : texture_.offsets) pad_ = std::max(pad_, o.cwiseAbs().maxCoeff());
  stride_ = picture_.width + 2 * pad_;
  const auto padded = static_cast<std::size_t>(stride_) * (picture_.height + 2 * pad_);
  level_.assign(padded, static_cast<std::uint8_t>(levels));
  painted_.assign(padded, 0);
  const auto n = pixels_in(picture_.width, picture_.height);
  occupied_.assign(n, 0);
  base_.assign(n, kNoLevel);
  source_.assign(n, -1);
  position_ = texture_.positions;
  std::vector<std::uint8_t> inside(n);
  for (std::size_t i = 0; i < n; ++i) inside[i] = texture_.level[i] != kNoLevel;
  source_pyramid_ = std::make_shared<const SourcePyramid>(
      source_pyramid(picture_.width, picture_.height, texture_.positions, inside));
  const double most = texture_.threshold * texture_.threshold;
  for (std::size_t i = 0; i < n; ++i) {
    float d = 0;
    const int k = texture_.levels.nearest(position_[i], &d);
    if (d > most) continue;
    base_[i] = k;
    if (dab_settings_.pairs == Pairs::Painted) continue;
    level_[(i / picture_.width + pad_) * stride_ + i % picture_.width + pad_] = k;
  }
  for (const auto& o : texture_.offsets)
    step_.push_back(static_cast<std::ptrdiff_t>(o.y()) * stride_ + o.x());
  by_home_.assign(texture_.by_home.size(), 0);
  by_remote_.assign(texture_.by_home.size(), 0);
  pairs_.assign(step_.size(), 0);
}

Rectangle Nib::bounds(const std::vector<std::uint32_t>& pixels) const {
  Rectangle r{picture_.width, picture_.height, 0, 0};
  for (const auto p : pixels) {
    const int x = static_cast<int>(p) % picture_.width, y = static_cast<int>(p) / picture_.width;
    r.x0 = std::min(r.x0, x);
    r.y0 = std::min(r.y0, y);
    r.x1 = std::max(r.x1, x + 1);
    r.y1 = std::max(r.y1, y + 1);
  }
  return pixels.empty() ? Rectangle{} : r;
}

// Adds a pixel's pairs to the counts (sign 1) or removes them (−1), as if it had `level`. If `painted_only`,
// counts only pairs with painted pixels.
void Nib::add(std::uint32_t pixel, int level, int sign, bool painted_only) {
  const std::size_t at = (pixel / picture_.width + pad_) * stride_ + pixel % picture_.width + pad_;
  const int levels = texture_.levels.count(), width = texture_.width;
  const auto rows = static_cast<std::size_t>(levels + 1) * width;
  for (std::size_t d = 0; d < step_.size(); ++d) {
    std::int32_t *home = &by_home_[d * rows], *remote = &by_remote_[d * rows];
    const std::size_t after = at + step_[d], before = at - step_[d];
    if (const int r = level_[after]; r < levels && (!painted_only || painted_[after])) {
      home[level * width + r] += sign;
      remote[r * width + level] += sign;
      pairs_[d] += sign;
    }
    if (const int r = level_[before]; r < levels && (!painted_only || painted_[before])) {
      home[r * width + level] += sign;
      remote[level * width + r] += sign;
      pairs_[d] += sign;
    }
  }
}

void Nib::clear(std::uint32_t pixel) {
  if (base_[pixel] == kNoLevel) return;
  if (dab_settings_.pairs == Pairs::Touching) add(pixel, base_[pixel], -1, true);
  base_[pixel] = kNoLevel;
  level_[(pixel / picture_.width + pad_) * stride_ + pixel % picture_.width + pad_] = texture_.levels.count();
}

// Returns the level with the least error, or −1 if no neighbor has a level. With the pixel taken out and K
// future pairs, level t adds (2·(C − K·p) + 1) / K² for each of its entries, where C − K·p is the difference
// from the goal, and 2 / K² more where both are the same entry.
template <int Vectors>
int Nib::best_level(std::uint32_t pixel) const {
  constexpr int kWidth = Vectors * kLanes;
  const int levels = texture_.levels.count();
  const auto rows = static_cast<std::size_t>(levels + 1) * kWidth;
  const std::uint8_t* at = &level_[(pixel / picture_.width + pad_) * stride_ + pixel % picture_.width + pad_];
  EightF cost[Vectors] = {};
  float both[kWidth + 1] = {};
  bool known = false;
  for (std::size_t d = 0; d < step_.size(); ++d) {
    const int after = at[step_[d]], before = at[-step_[d]];
    const int ends = (after < levels) + (before < levels);
    if (ends == 0) continue;
    known = true;
    const float k = 1.0f / (pairs_[d] + ends);
    const std::size_t a = d * rows + static_cast<std::size_t>(after) * kWidth,
                      b = d * rows + static_cast<std::size_t>(before) * kWidth;
    const auto *counts_a = reinterpret_cast<const Eight*>(&by_remote_[a]),
               *counts_b = reinterpret_cast<const Eight*>(&by_home_[b]);
    const auto *wanted_a = reinterpret_cast<const EightF*>(&texture_.by_remote[a]),
               *wanted_b = reinterpret_cast<const EightF*>(&texture_.by_home[b]);
    for (int v = 0; v < Vectors; ++v)
      cost[v] +=
          (__builtin_convertvector(counts_a[v] + counts_b[v], EightF) * k - (wanted_a[v] + wanted_b[v])) * k;
    if (after == before) both[after] += k * k;
  }
  if (!known) return -1;
  const auto* c = reinterpret_cast<const float*>(cost);
  int best = 0;
  for (int t = 1; t < levels; ++t)
    if (c[t] + both[t] < c[best] + both[best]) best = t;
  return best;
}

void Nib::visit(std::uint32_t pixel, std::uint64_t item) {
  if (occupied_[pixel]) add(pixel, base_[pixel], -1, false);
  const int levels = texture_.levels.count();
  int t = 0;
  switch (texture_.width / kLanes) {
    case 1:
      t = best_level<1>(pixel);
      break;
    case 2:
      t = best_level<2>(pixel);
      break;
    case 3:
      t = best_level<3>(pixel);
      break;
    default:
      t = best_level<4>(pixel);
      break;
  }
  if (t < 0) {
    const double u = Random(dab_settings_.seed, 0x91b0 + dabs_, item).uniform();
    t = std::upper_bound(texture_.histogram.begin(), texture_.histogram.end(), u) -
        texture_.histogram.begin();
    t = std::min(t, levels - 1);
  }
  place(pixel, t);
}

void Nib::place(std::uint32_t pixel, int level) {
  const std::size_t at = (pixel / picture_.width + pad_) * stride_ + pixel % picture_.width + pad_;
  add(pixel, level, 1, false);
  level_[at] = base_[pixel] = level;
  painted_[at] = occupied_[pixel] = 1;
}

void Nib::set_level(std::uint32_t pixel, int level) {
  add(pixel, base_[pixel], -1, false);
  place(pixel, level);
}

Rectangle Nib::dab(const std::vector<std::uint32_t>& footprint, const Work& work) {
  if (footprint.empty()) return {};
  ++dabs_;
  // Unpainted pixels under the nib are about to be replaced: they are no context.
  for (const auto p : footprint)
    if (!occupied_[p]) clear(p);
  std::vector<std::uint32_t> order = footprint;
  Random random(dab_settings_.seed, 0x91b1, dabs_);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  for (int pass = 0; pass < dab_settings_.passes; ++pass)
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i % 1024 == 0) {
        work.check();
        work.progress((pass + static_cast<double>(i) / order.size()) / dab_settings_.passes);
      }
      visit(order[i], i);
    }
  for (const auto p : footprint) {
    picture_.pixels[p] = texture_.levels.color[base_[p]];
    position_[p] = texture_.levels.center[base_[p]];
    source_[p] = -1;
  }
  if (dab_settings_.finish != Finish::Levels) restore_detail(footprint, work.quiet());
  return bounds(footprint);
}

Rectangle Nib::paint(const Stroke& s, const Work& work) {
  check_stroke(s);
  if (s.area) return dab(surrounded(picture_.width, picture_.height, s.parts), work);
  begin_stroke(s.radius);
  Rectangle all;
  for (std::size_t i = 0; i < s.parts[0].size(); ++i) {
    const Rectangle r =
        extend_stroke(s.parts[0][i], work.part(static_cast<double>(i) / s.parts[0].size(),
                                               static_cast<double>(i + 1) / s.parts[0].size()));
    if (r.x1 <= r.x0) continue;
    if (all.x1 <= all.x0) all = r;
    all = {std::min(all.x0, r.x0), std::min(all.y0, r.y0), std::max(all.x1, r.x1), std::max(all.y1, r.y1)};
  }
  return all;
}

void Nib::begin_stroke(double radius) {
  check_stroke({{{Vec2::Zero()}}, radius, false});
  radius_ = radius;
  first_point_ = true;
}

Rectangle Nib::extend_stroke(const Vec2& point, const Work& work) {
  check_stroke({{{point}}, radius_, false});
  const Vec2 from = first_point_ ? point : last_point_;
  last_point_ = point;
  first_point_ = false;
  return dab(capsule(picture_.width, picture_.height, from, point, radius_), work);
}

std::vector<std::int32_t> Nib::counts() const {
  const int levels = texture_.levels.count();
  std::vector<std::int32_t> out;
  for (std::size_t d = 0; d < step_.size(); ++d)
    for (int h = 0; h < levels; ++h)
      for (int r = 0; r < levels; ++r) out.push_back(by_home_[(d * (levels + 1) + h) * texture_.width + r]);
  return out;
}

std::vector<std::int32_t> Nib::fresh_counts() const {
  const std::size_t levels = texture_.levels.count();
  std::vector<std::int32_t> out(step_.size() * levels * levels, 0);
  for (std::size_t d = 0; d < step_.size(); ++d)
    for (int y = 0; y < picture_.height; ++y)
      for (int x = 0; x < picture_.width; ++x) {
        const int u = x + texture_.offsets[d].x(), v = y + texture_.offsets[d].y();
        if (u < 0 || v < 0 || u >= picture_.width || v >= picture_.height) continue;
        const std::size_t p = picture_.index(x, y), q = picture_.index(u, v);
        const bool counts = dab_settings_.pairs == Pairs::Touching ? occupied_[p] || occupied_[q]
                                                                   : occupied_[p] && occupied_[q];
        if (base_[p] != kNoLevel && base_[q] != kNoLevel && counts)
          ++out[(d * levels + base_[p]) * levels + base_[q]];
      }
  return out;
}

double Nib::error() const {
  const int levels = texture_.levels.count();
  double sum = 0;
  for (std::size_t d = 0; d < step_.size(); ++d) {
    if (pairs_[d] == 0) continue;
    for (int h = 0; h < levels; ++h)
      for (int r = 0; r < levels; ++r) {
        const std::size_t i = (d * (levels + 1) + h) * texture_.width + r;
        const double e = static_cast<double>(by_home_[i]) / pairs_[d] - texture_.by_home[i];
        sum += e * e;
      }
  }
  return sum;
}

}  // namespace terrazzo::texture_nib
