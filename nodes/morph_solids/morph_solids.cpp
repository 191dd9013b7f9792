#include "nodes/morph_solids/morph_solids.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/morph_solids/blend.h"
#include "nodes/morph_solids/color_morph.h"
#include "nodes/morph_solids/finish.h"
#include "runtime/random.h"

namespace terrazzo::morph_solids {
namespace {

constexpr int kDims = 32;  // coefficients that describe a patch
// Matching values changes the detail and restoring the detail changes values.
constexpr int kFinishRounds = 2;
constexpr int kCoarsestEdge = 24;  // least edge of the coarsest level, voxels

// What a patch uses of the solid of share 1 − weight (solid 0) or weight (solid 1).
std::vector<Use> uses(const Torus<float>& weight, int solid) {
  const Vec3i n = weight.size, patches = (n.array() + 1) / 2;
  std::vector<Use> out(static_cast<std::size_t>(patches.x()) * patches.y() * patches.z(), Use::None);
  for (std::size_t k = 0; k < out.size(); ++k) {
    const auto p = static_cast<int>(k);
    const Vec3i start(2 * (p % patches.x()), 2 * (p / patches.x() % patches.y()),
                      2 * (p / patches.x() / patches.y()));
    float least = 1, most = 0;
    for (int z = 0; z < kPatch; ++z)
      for (int y = 0; y < kPatch; ++y)
        for (int x = 0; x < kPatch; ++x) {
          const float w = weight.at[weight.index(wrapped(start.x() + x, n.x()), wrapped(start.y() + y, n.y()),
                                                 wrapped(start.z() + z, n.z()))];
          const float share = solid == 0 ? 1 - w : w;
          least = std::min(least, share), most = std::max(most, share);
        }
    out[k] = least >= 1 ? Use::Fixed : most > 0 ? Use::Free : Use::None;
  }
  return out;
}

struct Level {
  std::array<Torus<Vec3f>, 2> texture;
  Torus<float> weight;
};

std::vector<Level> pyramid(Level finest) {
  std::vector<Level> out = {std::move(finest)};
  while (out.back().weight.size.minCoeff() >= 2 * kCoarsestEdge)
    out.push_back({{half(out.back().texture[0], Vec3f(Vec3f::Zero())),
                    half(out.back().texture[1], Vec3f(Vec3f::Zero()))},
                   half(out.back().weight, 0.0f)});
  std::reverse(out.begin(), out.end());
  return out;
}

// Gives the voxels between the solids the distribution of the solids. Few voxels need not have it.
void match_between(const std::array<Quantiles, 3>& target, const Torus<float>& weight, Torus<Vec3f>& field,
                   const Work& work) {
  constexpr std::size_t kFewest = 4096;
  std::vector<std::size_t> between;
  for (std::size_t i = 0; i < weight.at.size(); ++i)
    if (weight.at[i] > 0 && weight.at[i] < 1) between.push_back(i);
  if (between.size() < kFewest) return;
  std::vector<float> values(between.size());
  for (int c = 0; c < 3; ++c) {
    const Quantiles& q = target[static_cast<std::size_t>(c)];
    if (!(q.most > q.least)) continue;
    for (std::size_t k = 0; k < between.size(); ++k) values[k] = field.at[between[k]][c];
    match_values(values, q, work.quiet());
    for (std::size_t k = 0; k < between.size(); ++k) field.at[between[k]][c] = values[k];
  }
}

// The distributions of the two solids' working values, which differ if the solids are scaled down.
std::array<Quantiles, 3> targets(const Level& level) {
  std::array<Quantiles, 3> out;
  for (int c = 0; c < 3; ++c) {
    std::array<Quantiles, 2> of;
    for (std::size_t s = 0; s < 2; ++s) {
      std::vector<float> values;
      for (const Vec3f& v : level.texture[s].at) values.push_back(v[c]);
      of[s] = quantiles_of(values);
    }
    out[static_cast<std::size_t>(c)] = mixture({&of[0], &of[1]});
  }
  return out;
}

// The field where a voxel is one of a or b, and the rest from random texels.
Torus<Vec3f> first_field(const Level& level, std::uint64_t seed) {
  Torus<Vec3f> out = level.texture[0];
  for (std::size_t i = 0; i < out.at.size(); ++i) {
    const float w = level.weight.at[i];
    if (w >= 1) out.at[i] = level.texture[1].at[i];
    if (w <= 0 || w >= 1) continue;
    Random random(seed, 0x73, i);
    const std::size_t s = random.uniform() < w ? 1 : 0;
    out.at[i] = level.texture[s].at[random.below(out.at.size())];
  }
  return out;
}

}  // namespace

double morph_memory(const Vec3i& size) {
  const double voxels = size.cast<double>().prod();
  // Two solids' descriptions and the result's, one eighth as many; the colors, working colors and filters.
  return voxels * (2.25 * kDims * sizeof(float) + 8 * sizeof(Vec3f) + 4 * sizeof(float));
}

MorphResult morph(const Torus<Vec3f>& a, const Torus<Vec3f>& b, const Torus<float>& weight,
                  const MorphSettings& s, const Work& work) {
  MorphResult out;
  out.color = a;
  for (std::size_t i = 0; i < weight.at.size(); ++i) {
    if (weight.at[i] >= 1) out.color.at[i] = b.at[i];
    out.synthesized += weight.at[i] > 0 && weight.at[i] < 1;
  }
  const ColorMorph colors(a.at, b.at);
  if (out.synthesized == 0) return out;

  Level finest{{a, b}, weight};
  for (int solid = 0; solid < 2; ++solid) {
    auto& values = finest.texture[static_cast<std::size_t>(solid)].at;
    work.quiet().parallel(values.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) values[i] = colors.to_working(solid, values[i]);
    });
  }
  std::vector<Level> levels = pyramid(std::move(finest));
  out.levels = static_cast<int>(levels.size());

  std::array<Matches, 2> matches;
  Torus<Vec3f> field;
  std::array<MatchLevel, 2> sources;
  int searches = 0;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    Level& level = levels[l];
    // A level takes eight times as long as the one below it.
    const double done =
        l == 0 ? 0 : std::pow(8.0, static_cast<double>(l) - static_cast<double>(levels.size()));
    const Work on_level =
        work.part(done, std::pow(8.0, static_cast<double>(l + 1) - static_cast<double>(levels.size())));
    const PatchSpace space(level.texture[0], level.texture[1], kDims, s.seed);
    const std::array<Quantiles, 3> target = targets(level);
    for (std::size_t solid = 0; solid < 2; ++solid) {
      MatchLevel fine{level.texture[solid], space.describe(level.texture[solid], 1, work.quiet()),
                      uses(level.weight, static_cast<int>(solid))};
      matches[solid] = l == 0 ? first_matches(fine, s.seed + solid)
                              : carry_up(matches[solid], sources[solid].texture, fine);
      sources[solid] = std::move(fine);
    }
    field = first_field(level, s.seed);
    const int rounds = s.iterations[std::min(l, s.iterations.size() - 1)];
    const auto blended = [&](double fall) {
      blend(sources, matches, level.weight, {s.exponent, s.window * std::pow(10, 1 - fall)}, field,
            work.quiet());
      match_between(target, level.weight, field, work);
    };
    if (l > 0) blended(0);
    for (int i = 0; i < rounds; ++i) {
      const std::vector<float> wanted = space.describe(field, 2, work.quiet());
      for (std::size_t solid = 0; solid < 2; ++solid)
        improve(matches[solid], sources[solid], wanted, kDims,
                {s.overuse, mix64(s.seed + 2 * static_cast<std::uint64_t>(searches++))}, work.quiet());
      blended(rounds > 1 ? static_cast<double>(i) / (rounds - 1) : 1);
      on_level.progress(static_cast<double>(i + 1) / rounds);
    }
  }
  for (int round = 0; round < kFinishRounds; ++round) {
    restore_detail(levels.back().texture, weight, field, work.quiet());
    match_between(targets(levels.back()), weight, field, work);
  }
  work.quiet().parallel(field.at.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (const float w = weight.at[i]; w > 0 && w < 1) out.color.at[i] = colors.to_linear(field.at[i], w);
  });
  return out;
}

}  // namespace terrazzo::morph_solids
