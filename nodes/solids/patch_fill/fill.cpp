#include "nodes/solids/patch_fill/fill.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/solids/patch_fill/blend.h"
#include "nodes/solids/patch_fill/color_morph.h"
#include "nodes/solids/patch_fill/finish.h"
#include "runtime/random.h"

namespace terrazzo::patch_fill {
namespace {

constexpr int kDims = 32;  // coefficients that describe a patch
// Matching values changes the detail and restoring the detail changes values.
constexpr int kFinishRounds = 2;
constexpr int kCoarsestEdge = 24;  // least edge of the coarsest level, voxels

// What a patch uses of the solid of share 1 − weight (solid 0) or weight (solid 1).
std::vector<Use> uses(const Torus<float>& weight, const Torus<float>& free, int solid, bool guided,
                      bool tiles) {
  const Vec3i n = weight.size, patches = (n.array() + 1) / 2;
  std::vector<Use> out(voxels_in(patches), Use::None);
  for (std::size_t k = 0; k < out.size(); ++k) {
    const int p = k;
    const Vec3i start(2 * (p % patches.x()), 2 * (p / patches.x() % patches.y()),
                      2 * (p / patches.x() / patches.y()));
    if (!tiles && ((start.array() + kPatch) > n.array()).any()) continue;
    float least = 1, most = 0;
    bool open = false;
    for (int z = 0; z < kPatch; ++z)
      for (int y = 0; y < kPatch; ++y)
        for (int x = 0; x < kPatch; ++x) {
          const std::size_t i = weight.index(wrapped(start.x() + x, n.x()), wrapped(start.y() + y, n.y()),
                                             wrapped(start.z() + z, n.z()));
          const float share = solid == 0 ? 1 - weight.at[i] : weight.at[i];
          least = std::min(least, share);
          most = std::max(most, share);
          open |= free.at[i] > 0;
        }
    if (most > 0 && open) out[k] = guided && solid == 1 ? Use::Fixed : Use::Free;
    if (least >= 1 && !open && !guided) out[k] = Use::Fixed;
  }
  return out;
}

// Colors are working colors. A voxel is known if no voxel under it is free.
struct Level {
  std::array<Torus<Vec3f>, 2> texture;
  Torus<float> weight, free;
  Torus<Vec3f> known;
};

std::vector<Level> pyramid(Level finest) {
  const Vec3f black = Vec3f::Zero();
  std::vector<Level> out = {std::move(finest)};
  while (out.back().weight.size.minCoeff() >= 2 * kCoarsestEdge) {
    const Level& fine = out.back();
    Level coarse{{half(fine.texture[0], black), half(fine.texture[1], black)},
                 half(fine.weight, 0.0f),
                 half(fine.free, 0.0f),
                 half(fine.known, black)};
    out.push_back(std::move(coarse));
  }
  std::reverse(out.begin(), out.end());
  return out;
}

// Gives the free voxels the distribution of the solids. Few voxels need not have it.
void match_free(const std::array<Quantiles, 3>& target, const Torus<float>& free, Torus<Vec3f>& field,
                const Work& work) {
  constexpr std::size_t kFewest = 4096;
  std::vector<std::size_t> between;
  for (std::size_t i = 0; i < free.at.size(); ++i)
    if (free.at[i] > 0) between.push_back(i);
  if (between.size() < kFewest) return;
  std::vector<float> values(between.size());
  for (int c = 0; c < 3; ++c) {
    const Quantiles& q = target[c];
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
    out[c] = mixture({&of[0], &of[1]});
  }
  return out;
}

// The known voxels, and the rest from random texels.
Torus<Vec3f> first_field(const Level& level, std::uint64_t seed) {
  Torus<Vec3f> out = level.known;
  for (std::size_t i = 0; i < out.at.size(); ++i) {
    if (level.free.at[i] <= 0) continue;
    Random random(seed, 0x73, i);
    const std::size_t s = random.uniform() < level.weight.at[i] ? 1 : 0;
    out.at[i] = level.texture[s].at[random.below(out.at.size())];
  }
  return out;
}

}  // namespace

double fill_memory(const Vec3i& size) {
  const double voxels = size.cast<double>().prod();
  // Two solids' descriptions and the result's, one eighth as many; about 20 arrays of colors while the finish
  // takes scales apart, and some of numbers.
  return voxels * (2.25 * kDims * sizeof(float) + 20 * sizeof(Vec3f) + 8 * sizeof(float));
}

namespace {

// The problem in working colors.
Level finest_level(const FillProblem& problem, const ColorMorph& colors, const Work& work) {
  Level finest{{problem.a, problem.b}, problem.weight, problem.free, problem.known};
  work.parallel(problem.free.at.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const int solid = problem.weight.at[i] < 0.5f ? 0 : 1;  // the one that a known voxel comes from
      finest.known.at[i] = colors.to_working(solid, problem.known.at[i]);
      for (int k = 0; k < 2; ++k) {
        Vec3f& v = finest.texture[k].at[i];
        v = colors.to_working(k, v);
      }
    }
  });
  return finest;
}

// What patches are matched to on a level.
MatchLevel sources_of(const Level& level, std::size_t solid, bool guided, bool tiles, const PatchSpace& space,
                      const Work& work) {
  MatchLevel out{level.texture[solid], {}, uses(level.weight, level.free, solid, guided, tiles)};
  if (std::count(out.use.begin(), out.use.end(), Use::Free) > 0)
    out.features = space.describe(out.texture, 1, work);
  return out;
}

}  // namespace

FillResult fill(const FillProblem& problem, const FillOptions& s, const Work& work) {
  FillResult out;
  out.color = problem.known;
  const bool guided = problem.sources == FillProblem::Sources::Guided;
  const Torus<float>& free = problem.free;
  const auto open = std::count_if(free.at.begin(), free.at.end(), [](float f) { return f > 0; });
  out.filled = open;
  const ColorMorph colors(problem.a.at, problem.b.at);
  if (out.filled == 0) return out;

  std::vector<Level> levels = pyramid(finest_level(problem, colors, work.quiet()));
  out.levels = levels.size();

  std::array<Matches, 2> matches;
  Torus<Vec3f> field;
  std::array<MatchLevel, 2> sources;
  int searches = 0;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const Level& level = levels[l];
    // A level takes eight times as long as the one below it.
    const double done = l == 0 ? 0 : std::pow(8.0, static_cast<double>(l) - levels.size());
    const Work on_level = work.part(done, std::pow(8.0, static_cast<double>(l + 1) - levels.size()));
    const PatchSpace space(level.texture[0], level.texture[1], kDims, s.seed);
    const std::array<Quantiles, 3> target = targets(level);
    for (std::size_t solid = 0; solid < 2; ++solid) {
      MatchLevel fine = sources_of(level, solid, guided, problem.tiles, space, work.quiet());
      matches[solid] = l == 0 ? first_matches(fine, s.seed + solid)
                              : carry_up(matches[solid], sources[solid].texture, fine);
      sources[solid] = std::move(fine);
    }
    field = first_field(level, s.seed);
    const int apart = guided ? level.weight.size.minCoeff() / FillProblem::kApart : 0;
    const int rounds = s.iterations[std::min(l, s.iterations.size() - 1)];
    const auto blended = [&](double fall) {
      blend(sources, matches, level.weight, level.free, {s.exponent, s.window * std::pow(10, 1 - fall)},
            field, work.quiet());
      match_free(target, level.free, field, work);
    };
    if (l > 0) blended(0);
    for (int i = 0; i < rounds; ++i) {
      const std::vector<float> wanted = space.describe(field, 2, work.quiet());
      for (std::size_t solid = 0; solid < 2; ++solid)
        improve(matches[solid], sources[solid], wanted, kDims,
                {s.overuse, apart, mix64(s.seed + 2 * static_cast<std::uint64_t>(searches++))}, work.quiet());
      blended(rounds > 1 ? static_cast<double>(i) / (rounds - 1) : 1);
      on_level.done(i + 1, rounds);
    }
  }
  for (int round = 0; round < kFinishRounds; ++round) {
    restore_detail(levels.back().texture, problem.weight, free, field, work.quiet());
    match_free(targets(levels.back()), free, field, work);
  }
  work.quiet().parallel(field.at.size(), 1 << 14, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (free.at[i] > 0) out.color.at[i] = colors.to_linear(field.at[i], problem.weight.at[i]);
  });
  return out;
}

}  // namespace terrazzo::patch_fill
